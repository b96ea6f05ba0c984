#include "apps/cli/motion_file.hpp"

#include "apps/cli/joint.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/config/text_file.hpp"
#include "sinew/family/sam/messages.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iostream>
#include <iterator>

namespace sinew::cli {

std::expected<sam::Program, Error> read_motion(const std::string& path)
{
    if (path == "-")
        return sam::assemble(std::string{std::istreambuf_iterator<char>{std::cin}, {}}, "stdin");
    const auto text = config::read_text(path, "a program of motions");
    if (!text)
        return std::unexpected(text.error());
    return sam::assemble(*text, path);
}

std::expected<std::vector<wire::Pair>, Error> motion_from_hex(std::span<const std::string> words)
{
    std::string text;
    for (const auto& word : words)
        text += word + ' ';
    const auto bytes = from_hex(text);
    if (!bytes)
        return std::unexpected(bytes.error());
    if (bytes->size() % 2 != 0 || bytes->size() > 2 * sam::most_instructions)
        return fail(Errc::bad_argument,
                    fmt::format("a program is 2 to 16 bytes, two for each instruction, and not {}", bytes->size()));
    std::vector<wire::Pair> out;
    for (std::size_t i = 0; i < bytes->size(); i += 2)
        out.push_back({(*bytes)[i], (*bytes)[i + 1]});
    return out;
}

std::string motion_bytes(std::span<const wire::Pair> program)
{
    std::vector<std::uint8_t> bytes;
    for (const auto& [first, second] : program)
        bytes.insert(bytes.end(), {first, second});
    return to_hex(bytes);
}

std::expected<wire::Request, Error> motion_request(const Device& device, std::span<const wire::Pair> program)
{
    if (device.family->name != "sam")
        return fail(Errc::unsupported,
                    fmt::format("only SAM servos run programs of their own; {} is a device of the family {}",
                                device.name, device.family->name));
    sam::WriteMotionData message{.motion_count = static_cast<std::uint8_t>(program.size())};
    std::ranges::copy(program, message.instructions.begin());
    auto asked = wire::make_request(device.id, message, device.options(), device.response_time());
    if (asked)
        asked->answered = device.answers(*asked->message);
    return asked;
}

std::expected<void, Error> check_motion(const Device& device, const sam::Program& program)
{
    const auto* joint = device.joint;
    if (joint == nullptr)
        return {};
    const auto refuse = [](const std::string& place, const Error& error) {
        return fail(error.code, fmt::format("{}: {}", place, to_sentence(error)));
    };
    for (std::size_t i = 0; i < program.instructions.size(); ++i) {
        const auto& instruction = program.instructions[i];
        if (sam::turns_on(instruction) && (joint->position_min_rad || joint->position_max_rad))
            return refuse(program.places[i],
                          {.code = Errc::out_of_range,
                           .detail = fmt::format("wheel turns {} without end, and {} gives it limits", device.name,
                                                 device.file->path)});
        if (const auto to = sam::goes_to_rad(instruction))
            if (const auto within = check_limits(device, to_joint_position(joint, *to), {}); !within)
                return refuse(program.places[i], within.error());
    }
    return {};
}

std::string instructions(std::size_t count)
{
    return fmt::format("{} instruction{}", count, count == 1 ? "" : "s");
}

} // namespace sinew::cli
