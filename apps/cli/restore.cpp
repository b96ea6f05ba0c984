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
    std::string from;         ///< the entry of the file
    /// In use as in the file; what is stored cannot be read.
    std::vector<WantedSetting> not_compared;
};

/// Settings of one joint are not those of another, whatever the model says: both must have been named.
std::expected<const config::DeviceEntry*, Error> entry_of(const Words& words, const config::DeviceFile& file,
                                                          const Device& device)
{
    const auto from = words.text("--from");
    const auto entry = entry_for(file, device, from);
    if (entry && !from && device.joint != nullptr && (*entry)->name != device.name)
        return fail(Errc::bad_argument,
                    fmt::format("{} has the settings of {} and not of {}; --from {} writes them to {}", file.path,
                                (*entry)->name, device.name, (*entry)->name, device.name));
    return entry;
}

std::expected<Work, Error> compare(const Words& words, Session& session, const config::DeviceFile& file, Device device)
{
    progress(fmt::format("Reading {}", device.name));
    Work work{.device = std::move(device)};
    const auto entry = entry_of(words, file, work.device);
    if (!entry)
        return std::unexpected(entry.error());
    work.from = (*entry)->name;
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
        const bool stored_unread = one.setting.trial != nullptr && one.setting.is_stored();
        if (same(one.values, *is) && !(stored_unread && words.has("--with-stored"))) {
            if (stored_unread)
                work.not_compared.push_back(one);
            continue;
        }
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
    if (words.has("--from") && !words.has("TARGET"))
        return fail(Errc::bad_argument, "--from says whose settings TARGET gets; name that as well");
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
            parts.push_back(fmt::format(
                "{} of {}{}", fmt::join(names, ", "), work.device.name,
                work.from == file_name_of(work.device) ? std::string{} : fmt::format(" (as {} had them)", work.from)));
    }
    return fmt::format("{} will be set, which writes flash {} {} and may take the torque off", fmt::join(parts, "; "),
                       stored, stored == 1 ? "time" : "times");
}

/// "pd-gain of elbow, wrist_yaw; angle-pid, speed-pid of left_knee"
std::string unread_names(const std::vector<Work>& all)
{
    std::vector<std::pair<std::string, std::vector<std::string_view>>> parts; // settings, and who has them
    for (const auto& work : all) {
        std::vector<std::string_view> names;
        for (const auto& one : work.not_compared)
            names.push_back(one.setting.info->name);
        if (names.empty())
            continue;
        auto joined = fmt::format("{}", fmt::join(names, ", "));
        const auto known = std::ranges::find(parts, joined, [](const auto& part) { return part.first; });
        if (known != parts.end())
            known->second.push_back(work.device.name);
        else
            parts.emplace_back(std::move(joined), std::vector<std::string_view>{work.device.name});
    }
    std::string out;
    for (const auto& [names, devices] : parts)
        out += fmt::format("{}{} of {}", out.empty() ? "" : "; ", names, fmt::join(devices, ", "));
    return out;
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
        Json unread = Json::array();
        for (const auto& one : work.not_compared)
            unread.add(one.setting.info->name);
        out.add(Json::object({{"device", work.device.name},
                              {"from", work.from},
                              {"written", std::move(names)},
                              {"not_compared", std::move(unread)},
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
    bool unread = false;
    for (const auto& work : *all) {
        unread = unread || !work.not_compared.empty();
        kept_out += work.kept_out;
        differ += work.differ.size();
    }
    if (kept_out > 0)
        fmt::print(stderr, "Calibration differs and is left as it is: it belongs to the device that it was read from "
                           "(--with-calibration writes it).\n");
    if (unread)
        fmt::print(
            stderr,
            "In use as in the file, and not compared with what is stored, which cannot be read: {} (--with-stored "
            "writes them).\n",
            unread_names(*all));
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
            fmt::print("no difference{}; nothing was written\n", unread ? " that can be read" : "");
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
    return {.name = "restore",
            .says = "Write saved settings to the devices: only what differs, and read back.",
            .arguments = {{"FILE", "what `sinew save` wrote"},
                          {"TARGET", "a joint, or a link with --family and --id; without it all of FILE", false}},
            .options = with_device_options(
                {{"--with-calibration", "", "calibration too: onto the device that it was read from"},
                 {"--with-stored", "", "also what is in use already, where what is stored cannot be read"},
                 {"--from", "NAME", "the device of FILE whose settings are written, where it has another name"},
                 {"--dry-run", "", "read and compare, show the bytes of what differs, write nothing"},
                 yes_option,
                 json_option}),
            .examples = {{"sinew restore kept.toml --robot arm.toml --dry-run", "what differs"},
                         {"sinew restore kept.toml elbow --robot arm.toml --yes", "one joint"},
                         {"sinew restore kept.toml elbow --from elbow --robot arm.toml --with-stored --yes",
                          "both named, and gains although they are in use"},
                         {"sinew restore kept.toml serial:/dev/ttyUSB0 --family sam --id 1",
                          "a device in the place of the one that was saved; asks first"}},
            .run = run,
            .acts = true,
            .more =
                "A device of another family, model or firmware line is refused. No family tells a serial number, so "
                "calibration is never written unless it is asked for. Gains and "
                "other settings that can be tried until power-off are read as they are in use; no family tells what is "
                "in flash. Everything is read and compared before "
                "anything is written."};
}

} // namespace sinew::cli
