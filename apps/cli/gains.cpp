#include "apps/cli/gains.hpp"

#include "apps/cli/flash_ledger.hpp"
#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

struct Wanted {
    LineSetting setting;
    std::string_view field;
    std::int64_t raw = 0;
};

/// A gain that a device is set to.
std::expected<Wanted, Error> wanted(const Device& device, const std::string& word)
{
    const auto equals = word.find('=');
    const auto raw = equals == std::string::npos ? std::unexpected(Error{}) : to_integer(word.substr(equals + 1));
    if (!raw)
        return fail(Errc::bad_argument, fmt::format("--gain takes NAME=N, such as p=30, not '{}'", word));
    const auto name = std::string_view(word).substr(0, equals);
    const auto settings = settings_of(device);
    std::vector<std::string_view> names;
    for (const auto& gain : gains_of(*device.family)) {
        const auto setting =
            std::ranges::find(settings, gain.setting, [](const LineSetting& one) { return one.info->name; });
        if (setting == settings.end())
            continue;
        if (setting->trial == nullptr)
            return fail(Errc::unsupported,
                        fmt::format("a {} stores its gains in flash at once, so they are not tried; sinew set {} {} "
                                    "writes them",
                                    device.family->name, device.name, gain.setting));
        names.push_back(gain.name);
        if (gain.name == name)
            return Wanted{*setting, gain.field, *raw};
    }
    if (names.empty())
        return fail(Errc::unsupported, fmt::format("the firmware line {} of {} has no gains that can be set",
                                                   device.line().name, device.family->name));
    return fail(Errc::unknown_name,
                fmt::format("{} has no gain '{}'; it has {}", device.family->name, name, fmt::join(names, ", ")));
}

std::expected<wire::Request, Error> request_of(const Device& device, const LineSetting& setting,
                                               const wire::MessageInfo& message, const wire::Values& values)
{
    const auto needed = written_values(setting, message, values, device.options());
    return needed ? request(device, message, *needed) : std::unexpected(needed.error());
}

} // namespace

std::expected<void, Error> Gains::check(const Device& device, std::span<const std::string> words)
{
    for (const auto& word : words)
        if (const auto one = wanted(device, word); !one)
            return std::unexpected(one.error());
    return {};
}

std::expected<Gains, Error> Gains::from(bus::Bus& bus, const Device& device, std::span<const std::string> words)
{
    Gains out;
    for (const auto& word : words) {
        const auto gain = wanted(device, word);
        if (!gain)
            return std::unexpected(gain.error());
        auto known = std::ranges::find(out.all_, gain->setting.info, [](const One& one) { return one.setting.info; });
        if (known == out.all_.end()) {
            const auto before = read_setting(bus, device, gain->setting);
            if (!before)
                return std::unexpected(before.error());
            known = out.all_.insert(out.all_.end(), One{gain->setting, *before, *before});
        }
        wire::Values now;
        for (const auto& value : known->now)
            now.add(*value.field, value.field->name == gain->field ? gain->raw : value.raw);
        known->now = now;
    }
    // What cannot be sent is known before anything is.
    for (const auto& one : out.all_)
        for (const auto* message : {one.setting.trial, one.setting.write})
            if (const auto asked = request_of(device, one.setting, *message, one.now); !asked)
                return std::unexpected(asked.error());
    return out;
}

std::expected<void, Error> Gains::set_trial(bus::Bus& bus, const Device& device) const
{
    for (const auto& one : all_) {
        const auto asked = request_of(device, one.setting, *one.setting.trial, one.now);
        if (!asked)
            return std::unexpected(asked.error());
        if (const auto sent = ask(bus, *asked); !sent)
            return std::unexpected(sent.error());
    }
    return {};
}

std::expected<void, Error> Gains::set_back(bus::Bus& bus, const Device& device) const
{
    std::expected<void, Error> out;
    for (const auto& one : all_) {
        const auto asked = request_of(device, one.setting, *one.setting.trial, one.before);
        const auto sent = asked ? ask(bus, *asked) : std::unexpected(asked.error());
        if (!sent && out)
            out = std::unexpected(sent.error());
    }
    return out;
}

std::expected<void, Error> Gains::store(bus::Bus& bus, const Device& device) const
{
    for (const auto& one : all_) {
        // Also where they are in use already: what is stored is not known.
        const auto asked = request_of(device, one.setting, *one.setting.write, one.now);
        if (!asked)
            return std::unexpected(asked.error());
        if (const auto sent = ask_counted(bus, device, *asked); !sent) {
            std::string stored;
            for (const auto& before : std::span(all_).first(static_cast<std::size_t>(&one - all_.data())))
                stored += fmt::format("{} is in flash, ", before.setting.info->name);
            return fail(sent.error().code, fmt::format("{}whether {} of {} is in flash is not known: {}", stored,
                                                       one.setting.info->name, device.name, to_sentence(sent.error())));
        }
    }
    return {};
}

} // namespace sinew::cli
