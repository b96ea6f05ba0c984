#include "apps/cli/recorded_robot.hpp"

#include "sinew/config/text_file.hpp"
#include "sinew/record/mcap_reader.hpp"
#include "sinew/record/topics.hpp"

#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>

namespace sinew::cli {
namespace {

namespace mcap = record::mcap;

std::expected<std::string, Error> robot_text_in_recording(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    mcap::Reader reader;
    std::array<char, 64 * 1024> piece;
    for (;;) {
        const auto item = reader.next();
        if (!item)
            continue; // what can be read behind the damage is read
        if (!*item && !file)
            return fail(Errc::bad_file,
                        fmt::format("{} keeps no robot file; only a recording of a whole robot has one", path));
        if (!*item) {
            file.read(piece.data(), piece.size());
            reader.feed(record::bytes_of({piece.data(), static_cast<std::size_t>(file.gcount())}));
            if (!file)
                reader.end();
        } else if (const auto* attachment = std::get_if<mcap::Attachment>(&**item);
                   attachment != nullptr && attachment->name == record::robot_attachment) {
            return attachment->data;
        }
    }
}

} // namespace

bool is_recording(const std::string& path)
{
    std::error_code none;
    if (!std::filesystem::is_regular_file(path, none))
        return false; // a pipe can be read only once
    std::ifstream file(path, std::ios::binary);
    std::array<char, mcap::magic.size()> first{};
    return file.read(first.data(), first.size()) && std::string_view(first.data(), first.size()) == mcap::magic;
}

std::expected<std::string, Error> robot_text_at(const std::string& path)
{
    if (is_recording(path))
        return robot_text_in_recording(path);
    return config::read_text(path, "a robot file or a recording");
}

std::expected<config::RobotFile, Error> robot_file_at(const std::string& path)
{
    if (!is_recording(path))
        return config::read_robot_file(path);
    const auto text = robot_text_in_recording(path);
    if (!text)
        return std::unexpected(text.error());
    auto file = config::parse_robot_file(*text, path);
    if (file)
        for (auto& bus : file->buses)
            bus.link = {fmt::format("replay:{}#{}", path, bus.name), bus.at};
    return file;
}

} // namespace sinew::cli
