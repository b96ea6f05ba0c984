#include "apps/cli/device.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/record/replay.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

template <class Rows, class Name>
std::unexpected<Error> unknown(std::string_view kind, std::string_view word, const Rows& rows, const Name& name)
{
    std::vector<std::string_view> names;
    for (const auto& row : rows)
        names.push_back(name(row));
    const auto near = did_you_mean(word, names);
    return fail(Errc::unknown_name,
                fmt::format("there is no {} '{}'{}", kind, word,
                            near.empty() ? fmt::format("; there are {}", fmt::join(names, ", ")) : near));
}

std::expected<int, Error> id_of(const Words& words, const Family& family)
{
    const auto id = words.number("--id", -1'000'000, 1'000'000);
    if (!id)
        return std::unexpected(id.error());
    if (!*id)
        return fail(Errc::bad_argument, fmt::format("the id of the device is missing: add --id N ({} … {})",
                                                    family.ids.low, family.ids.high));
    if (!family.ids.contains(**id) && **id != family.broadcast_id)
        return fail(Errc::bad_id, fmt::format("id {} is outside the ids of {}: {} … {}", **id, family.name,
                                              family.ids.low, family.ids.high));
    return static_cast<int>(**id);
}

} // namespace

std::string suggestion(std::string_view name, std::span<const std::string_view> names)
{
    return names.empty() || !nearest(name, names).empty() ? did_you_mean(name, names)
                                                          : fmt::format("; it has {}", fmt::join(names, ", "));
}

bool Device::answers(const wire::MessageInfo& message) const
{
    if (!message.reply.exists() || (message.info.broadcast && id == family->broadcast_id))
        return false;
    if (!spec)
        return !message.info.answered_as_command;
    return sinew::answers(*spec, message);
}

Error about(const Device& device, Error error)
{
    if (error.id != device.id || device.id < 0)
        return error; // of nobody, or told already
    Error plain = error;
    plain.message = {};
    plain.id = -1;
    plain.seen_size = 0;
    std::string what = to_sentence(plain);
    if (error.code == Errc::timeout && record::is_replay(device.link))
        what = "the recording has no answer to this, or no further one";
    const auto name = device.joint != nullptr ? device.name : fmt::format("id {}", device.id);
    const auto whom = error.message.empty() ? name : fmt::format("{} to {}", error.message, name);
    error.detail = fmt::format("{}: {}", whom, what);
    error.message = {};
    error.id = -1;
    return error;
}

std::expected<const Family*, Error> family_named(std::string_view name)
{
    if (const auto* family = find_family(name))
        return family;
    return unknown("family", name, families(), [](const Family* f) { return f->name; });
}

std::expected<const wire::Profile*, Error> profile_named(const Family& family, std::string_view name)
{
    if (const auto* profile = name.empty() ? family.profiles.front() : family.find_profile(name))
        return profile;
    return unknown(fmt::format("{} profile", family.name), name, family.profiles,
                   [](const wire::Profile* p) { return p->name; });
}

std::expected<const wire::MessageInfo*, Error> message_named(const Family& family, const wire::Profile& line,
                                                             std::string_view name)
{
    if (const auto* message = line.find(name))
        return message;
    for (const auto* other : family.profiles)
        if (other->find(name) != nullptr)
            return fail(Errc::not_in_profile,
                        fmt::format("{} does not exist on the firmware line {}, so it is not sent; {} has it", name,
                                    line.name, other->name));
    std::vector<std::string_view> names;
    for (const auto* message : line.messages)
        names.push_back(message->name());
    const auto near = did_you_mean(name, names);
    return fail(Errc::unknown_name,
                fmt::format("{} has no message '{}'{}", family.name, name,
                            near.empty() ? fmt::format("; `sinew messages {}` lists them", family.name) : near));
}

std::expected<Device, Error> device_of(const Words& words, std::string_view link)
{
    const auto family_name = words.text("--family");
    if (!family_name)
        return fail(Errc::bad_argument, "the family of the device is missing: add --family sam, nuri or rmd");
    const auto family = family_named(*family_name);
    if (!family)
        return std::unexpected(family.error());
    const auto id = id_of(words, **family);
    if (!id)
        return std::unexpected(id.error());
    const auto profile = profile_named(**family, words.text("--profile").value_or(""));
    if (!profile)
        return std::unexpected(profile.error());
    Device device{.name = fmt::format("{} {}", (*family)->name, *id),
                  .link = std::string(link),
                  .family = *family,
                  .id = *id,
                  .asked_line = *profile};
    const auto model = words.text("--model").value_or("");
    // Without a model a SAM is only messages; the other families know what to do without one.
    if (!(*family)->ids.contains(*id) || (model.empty() && !make_spec(**family, "", "", (*family)->default_id)))
        return device;
    auto spec = make_spec(**family, model, words.text("--profile").value_or(""), *id);
    if (!spec)
        return std::unexpected(spec.error());
    device.spec = std::move(*spec);
    return device;
}

std::expected<wire::Request, Error> request(const Device& device, const wire::MessageInfo& message,
                                            const wire::Values& values)
{
    if (device.spec && !offers(*device.spec, message))
        return fail(Errc::unsupported,
                    fmt::format("{} has no {}; only {} do", device.model(), message.name(), message.info.restriction));
    const auto frame = wire::encode(message, wire::Direction::request, device.id, values, device.options());
    if (!frame)
        return std::unexpected(frame.error());
    return wire::Request{.id = device.id,
                         .message = &message,
                         .frame = *frame,
                         .options = device.options(),
                         .answered = device.answers(message),
                         .response_time = device.response_time()};
}

std::expected<wire::Values, Error> reply_values(const wire::Request& asked, const wire::Frame& reply)
{
    auto decoded = wire::decode(*asked.message, wire::Direction::reply, reply, asked.options);
    if (decoded)
        return decoded->values;
    Error error = decoded.error();
    error.detail = fmt::format("the answer of id {} is wrong: {}", asked.id, to_sentence(error));
    return std::unexpected(Error{.code = Errc::bad_reply, .detail = error.detail});
}

std::vector<Option> with_device_options(std::vector<Option> options)
{
    for (const auto& option :
         {robot_option, sim_option, link_option, family_option, id_option, model_option, profile_option})
        options.push_back(option);
    return options;
}

} // namespace sinew::cli
