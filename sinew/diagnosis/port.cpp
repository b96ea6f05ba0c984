#include "sinew/diagnosis/walk.hpp"
#include "sinew/link/slcan.hpp"

#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

namespace sinew::diagnosis {
namespace {

/// FTDI's timer as it comes is 16 ms.
constexpr int slow_timer_ms = 2;

/// The device file of the link; nothing for links that are no file.
std::optional<std::string> device_of(const Walk& walk)
{
    constexpr std::array<std::string_view, 4> schemes{"serial", "rs485", "pty", "slcan"};
    if (!walk.uri || std::ranges::find(schemes, walk.uri->scheme) == schemes.end())
        return std::nullopt;
    return walk.uri->target;
}

bool is_pseudo_terminal(const std::string& device)
{
    return std::filesystem::path(device).parent_path() == "/dev/pts";
}

std::string ports_there()
{
    std::vector<std::string> names;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator("/dev", none)) {
        const auto name = entry.path().filename().string();
        if (name.starts_with("ttyUSB") || name.starts_with("ttyACM"))
            names.push_back(entry.path().string());
    }
    std::ranges::sort(names);
    return names.empty() ? "no USB serial port is there at all" : fmt::format("there is {}", fmt::join(names, ", "));
}

void check_interface(Walk& walk, const std::expected<link::CanInterface, Error>& interface)
{
    if (!interface)
        walk.add(interface.error().code == Errc::link_not_found ? "device-missing" : "link-failed",
                 to_sentence(interface.error()), "`ip -details link show type can` lists what there is.");
    else if (!interface->is_up)
        walk.add("interface-down", fmt::format("{} is down", interface->name),
                 fmt::format("`{}`", link::how_to_bring_up(*interface)));
    else
        walk.fine("device-file", fmt::format("{} is up", interface->name));
}

void check_controller(Walk& walk, const link::CanInterface& interface)
{
    using enum link::CanState;
    const auto evidence = fmt::format("{}: {}, {} errors sending and {} receiving, {} times bus-off, txqueuelen {}",
                                      interface.name, to_word(interface.state), interface.tx_errors,
                                      interface.rx_errors, interface.bus_offs, interface.tx_queue);
    if (interface.state == bus_off || interface.state == error_passive)
        walk.add("can-errors", evidence);
    else if (interface.state == error_warning || interface.bus_offs > 0)
        walk.add("can-errors", evidence).severity = Severity::warning;
    else
        walk.fine("adapter", evidence);
}

void add_no_permission(Walk& walk, const std::string& device)
{
    const auto adapter = walk.look_at(device);
    const bool has_group = !adapter.group.empty();
    walk.add("no-permission",
             has_group ? fmt::format("{} belongs to the group {}", device, adapter.group)
                       : fmt::format("{} is for its owner only", device),
             has_group
                 ? fmt::format("Join the group with `sudo usermod -aG {} $USER`, then log in again.", adapter.group)
                 : std::string{});
}

/// Why the link does not open.
void add_refusal(Walk& walk, const Error& error)
{
    const auto device = device_of(walk);
    if (error.code == Errc::link_busy) {
        const auto who = device ? walk.who_holds(*device) : std::string{};
        walk.add("port-busy", who.empty() ? to_sentence(error) : fmt::format("{} is held by {}", *device, who),
                 who.empty() ? std::string{} : fmt::format("Close {}, then try again.", who));
    } else if (error.code == Errc::link_denied && device) {
        add_no_permission(walk, *device);
    } else if (error.code == Errc::link_not_found && walk.uri && walk.uri->scheme == "tcp") {
        walk.add("box-unreachable", to_sentence(error));
    } else {
        walk.add(error.code == Errc::link_not_found && device ? "device-missing" : "link-failed", to_sentence(error));
    }
}

/// "open at 1498127 bps, where 1500000 were asked for", as far as it is known.
std::string rate_of(const Walk& walk)
{
    const auto rate = walk.line->bit_rate();
    if (rate == 0)
        return "open; it does not tell its bit rate";
    const auto asked = walk.uri ? walk.uri->number("baud") : std::optional<std::uint32_t>{};
    const bool differs = !walk.line->can() && asked && *asked && **asked != rate;
    return fmt::format("open at {} bps{}, and nobody else has it", rate,
                       differs ? fmt::format(", where {} were asked for", **asked) : "");
}

const link::SlcanLink* slcan_of(const Walk& walk)
{
    const auto* can = walk.line ? std::get_if<std::unique_ptr<link::CanLink>>(&walk.line->link()) : nullptr;
    return can != nullptr ? dynamic_cast<const link::SlcanLink*>(can->get()) : nullptr;
}

/// What the adapter kept of errors on its bus.
void judge_flags(Walk& walk, std::uint8_t flags)
{
    namespace flag = link::slcan::flag;
    const auto evidence = fmt::format("the SLCAN adapter reports {}", link::slcan::to_words(flags));
    if ((flags & flag::error_passive) != 0)
        walk.add("bus-errors", evidence).severity = Severity::error;
    else if ((flags & (flag::bus_error | flag::error_warning)) != 0)
        walk.add("bus-errors", evidence);
    if ((flags & (flag::overrun | flag::receive_queue_full)) != 0)
        walk.add("frames-lost", evidence);
}

/// "3 frames that nobody acknowledged, 1 times bus-off", of those that happened.
std::string those_that_mean(link::Tally::Means what, const link::Report& report)
{
    std::vector<std::string> out;
    for (const auto& tally : report.tallies)
        if (tally.means == what && tally.count != 0)
            out.push_back(fmt::format("{} {}", tally.count, tally.says));
    return fmt::format("{}", fmt::join(out, ", "));
}

} // namespace

void check_device_file(Walk& walk)
{
    if (const auto interface = walk.can_interface())
        return check_interface(walk, *interface);
    const auto device = device_of(walk);
    if (!device)
        return;
    const auto adapter = walk.look_at(*device);
    if (!adapter.is_there)
        walk.add("device-missing", fmt::format("{} does not exist; {}", *device, ports_there()));
    else
        walk.fine("device-file", adapter.device == *device || adapter.device.empty()
                                     ? *device
                                     : fmt::format("{}, which is {}", *device, adapter.device));
}

void check_permission(Walk& walk)
{
    const auto device = device_of(walk);
    if (!device)
        return;
    const auto adapter = walk.look_at(*device);
    if (!adapter.is_there)
        return;
    if (adapter.may_open)
        walk.fine("permission", "this user may read and write it");
    else
        add_no_permission(walk, *device);
}

void check_port(Walk& walk)
{
    if (walk.has("device-missing") || walk.has("no-permission") || walk.has("interface-down") ||
        walk.has("link-failed"))
        return;
    const auto device = device_of(walk);
    auto opened = walk.open();
    if (!opened)
        return add_refusal(walk, opened.error());
    walk.line = std::make_unique<Line>(std::move(opened->link), *opened->clock);
    const bool says_rate = walk.uri && walk.uri->option("baud").has_value();
    if (walk.subject.bit_rate != 0 && !walk.line->can() && !says_rate)
        (void)walk.line->set_bit_rate(walk.subject.bit_rate);
    if (walk.family != nullptr && walk.family->can != walk.line->can()) {
        walk.line.reset();
        walk.add("link-failed", fmt::format("{} devices are on {}, which {} is not", walk.family->name,
                                            walk.family->can ? "CAN" : "serial lines", walk.subject.link));
        return;
    }
    std::vector<std::string> others;
    if (device && !is_pseudo_terminal(*device))
        for (const auto& holder : walk.look_at(*device).holders)
            if (holder.pid != ::getpid())
                others.push_back(
                    fmt::format("{} (pid {})", holder.program.empty() ? "a program" : holder.program, holder.pid));
    if (!others.empty())
        walk.add("port-shared", fmt::format("{} has {} open", fmt::join(others, ", "), *device));
    else
        walk.fine("port", rate_of(walk));
}

void check_adapter(Walk& walk)
{
    if (const auto interface = walk.can_interface(); interface && *interface && (*interface)->is_up)
        return check_controller(walk, **interface);
    const auto device = device_of(walk);
    if (!device)
        return;
    // After the port was opened: that switches the timer of some drivers to low latency.
    const auto adapter = walk.look_at(*device);
    if (!adapter.is_there)
        return;
    const auto settings = walk.line ? walk.report().settings : link::settings_of(adapter, {}, false);
    const auto name = std::filesystem::path(adapter.device).filename().string();
    if (const auto timer = adapter.latency_timer_ms; timer && *timer > slow_timer_ms)
        walk.add("slow-adapter", fmt::format("of {}: {}", name, link::to_words(settings)),
                 fmt::format("`echo 1 | sudo tee /sys/bus/usb-serial/devices/{}/latency_timer`; a udev rule makes it "
                             "stay.",
                             name));
    else
        walk.fine("adapter", settings.empty() ? "no latency timer" : link::to_words(settings));
    const auto rs485 = std::ranges::find(settings, "rs485", &link::Setting::name);
    if (rs485 != settings.end() && !std::get<bool>(rs485->value))
        walk.add("direction-not-switched", rs485->says);
    if (const auto* slcan = slcan_of(walk); slcan != nullptr && !slcan->has_answered())
        walk.add("adapter-silent", "neither the rate nor the opening of the CAN bus was acknowledged");
}

Checked check_counters(Walk& walk)
{
    if (!walk.line->can())
        return {};
    const auto before = walk.count();
    const auto flags = walk.line->adapter_flags();
    if (!flags)
        return std::unexpected(flags.error());
    if (*flags && **flags != 0)
        judge_flags(walk, **flags);
    const auto report = walk.report();
    if (const auto lost = those_that_mean(link::Tally::Means::loss, report); !lost.empty() && !walk.has("frames-lost"))
        walk.add("frames-lost", lost);
    if (const auto seen = those_that_mean(link::Tally::Means::trouble, report);
        !seen.empty() && !walk.has("bus-errors"))
        walk.add("bus-errors", seen);
    if (!report.tallies.empty() && walk.count() == before)
        walk.fine("counters", "no error on the bus, no frame lost");
    return {};
}

} // namespace sinew::diagnosis
