#include "apps/cli/confirm.hpp"
#include "apps/cli/device_settings.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/presence.hpp"
#include "apps/cli/terminal.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

/// What a device would get that it does not have.
struct Work {
    Device device;
    bus::Bus* bus = nullptr;
    std::vector<WantedSetting> differ;
    std::size_t kept_out = 0; ///< calibration that is not asked for
};

std::expected<Work, Error> compare(const Words& words, Session& session, const config::DeviceFile& file, Device device)
{
    progress(fmt::format("Reading {}", device.name));
    Work work{.device = std::move(device)};
    const auto entry = entry_for(file, work.device);
    if (!entry)
        return std::unexpected(entry.error());
    const auto bus = session.bus_of(work.device);
    if (!bus)
        return std::unexpected(bus.error());
    work.bus = *bus;
    if (auto found = find_model(work.device, **bus); !found)
        return std::unexpected(found.error());
    if (auto fine = check_same_kind(file, **entry, work.device, *bus); !fine)
        return std::unexpected(fine.error());
    const auto wanted = wanted_settings(file, **entry, work.device);
    if (!wanted)
        return std::unexpected(wanted.error());
    for (const auto& one : *wanted) {
        const auto is = read_setting(**bus, work.device, one.setting);
        if (!is)
            return std::unexpected(is.error());
        if (same(one.values, *is))
            continue;
        if (one.calibration && !words.has("--with-calibration"))
            ++work.kept_out;
        else
            work.differ.push_back(one);
    }
    return work;
}

/// Everything is compared before anything is written.
std::expected<std::vector<Work>, Error> compare_all(const Words& words, Session& session)
{
    const auto file = config::read_device_file(*words.text("FILE"));
    if (!file)
        return std::unexpected(file.error());
    auto devices = targets_of(words, *file);
    if (!devices)
        return std::unexpected(devices.error());
    std::vector<Work> all;
    for (auto& device : *devices) {
        auto work = compare(words, session, *file, std::move(device));
        if (!work)
            return std::unexpected(work.error());
        all.push_back(std::move(*work));
    }
    end_progress();
    return all;
}

std::string question(const std::vector<Work>& all)
{
    std::vector<std::string> parts;
    std::size_t stored = 0;
    for (const auto& work : all) {
        std::vector<std::string_view> names;
        for (const auto& one : work.differ) {
            names.push_back(one.setting.info->name);
            stored += one.setting.is_stored() ? 1 : 0;
        }
        if (!names.empty())
            parts.push_back(fmt::format("{} of {}", fmt::join(names, ", "), work.device.name));
    }
    return fmt::format("{} will be set, which writes flash {} {} and may take the torque off", fmt::join(parts, "; "),
                       stored, stored == 1 ? "time" : "times");
}

/// Writes one setting and reads it back.
std::expected<void, Error> write(Session& session, const Work& work, const WantedSetting& one)
{
    const auto sent = ask_counted(*work.bus, work.device, one.write);
    // Whether it is answered can be what it sets; what is read back decides.
    if (!sent && sent.error().code != Errc::timeout)
        return std::unexpected(sent.error());
    constexpr Duration unasked = std::chrono::milliseconds(20); // for an answer that is not due
    wait_until(session, session.clock().now() + unasked);
    const auto is = read_setting(*work.bus, work.device, one.setting);
    if (!is)
        return std::unexpected(is.error());
    if (!same(one.values, *is))
        return fail(Errc::bad_reply, fmt::format("{} of {} was written and is not what it should be; is its flash worn "
                                                 "out?",
                                                 one.setting.info->name, work.device.name));
    return {};
}

Json to_json(const std::vector<Work>& all)
{
    Json out = Json::array();
    for (const auto& work : all) {
        Json names = Json::array();
        for (const auto& one : work.differ)
            names.add(one.setting.info->name);
        out.add(Json::object({{"device", work.device.name},
                              {"written", std::move(names)},
                              {"calibration_left_out", static_cast<std::int64_t>(work.kept_out)}}));
    }
    return out;
}

Outcome write_all(const Words& words, Session& session, const std::vector<Work>& all)
{
    std::size_t written = 0;
    for (const auto& work : all)
        for (const auto& one : work.differ) {
            if (auto done = write(session, work, one); !done) {
                if (written > 0)
                    fmt::print(stderr, "{} {} written before that.\n", written,
                               written == 1 ? "setting was" : "settings were");
                return std::unexpected(done.error());
            }
            ++written;
            if (!words.json())
                fmt::print("{}  {}\n", work.device.name, one.setting.info->name);
        }
    if (words.json())
        print(to_json(all));
    return exit_done;
}

Outcome run(const Words& words)
{
    Session session;
    const auto all = compare_all(words, session);
    if (!all)
        return std::unexpected(all.error());
    std::size_t kept_out = 0, differ = 0;
    for (const auto& work : *all) {
        kept_out += work.kept_out;
        differ += work.differ.size();
    }
    if (kept_out > 0)
        fmt::print(stderr, "Calibration differs and is left as it is: it belongs to the device that it was read from "
                           "(--with-calibration writes it).\n");
    if (words.has("--dry-run")) {
        for (const auto& work : *all) {
            std::vector<wire::Request> requests;
            for (const auto& one : work.differ)
                requests.push_back(one.write);
            show_unsent(words, work.device, requests);
        }
        return exit_done;
    }
    if (differ == 0) {
        if (words.json())
            print(to_json(*all));
        else
            fmt::print("no difference; nothing was written\n");
        return exit_done;
    }
    const auto yes = confirm(words, question(*all));
    if (!yes)
        return std::unexpected(yes.error());
    return *yes ? write_all(words, session, *all) : Outcome(exit_refused);
}

} // namespace

Verb restore_verb()
{
    return {
        .name = "restore",
        .says = "Write saved settings to the devices: only what differs, and read back.",
        .arguments = {{"FILE", "what `sinew save` wrote"},
                      {"TARGET", "a joint, or a link with --family and --id; without it all of FILE", false}},
        .options =
            with_device_options({{"--with-calibration", "", "calibration too: onto the device that it was read from"},
                                 {"--dry-run", "", "read and compare, show the bytes of what differs, write nothing"},
                                 yes_option,
                                 json_option}),
        .examples = {{"sinew restore kept.toml --robot arm.toml --dry-run", "what differs"},
                     {"sinew restore kept.toml elbow --robot arm.toml --yes", "one joint"},
                     {"sinew restore kept.toml serial:/dev/ttyUSB0 --family sam --id 1",
                      "a device in the place of the one that was saved; asks first"}},
        .run = run,
        .more = "A device of another family, model or firmware line is refused. No family tells a serial number, so "
                "calibration is never written unless it is asked for. Everything is read and compared before "
                "anything is written."};
}

} // namespace sinew::cli
