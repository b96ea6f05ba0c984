#include "sinew/link/report.hpp"

#include "sinew/link/slcan.hpp"
#include "sinew/link/socketcan.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace sinew::link {
namespace {

void append(std::vector<Setting>& to, std::vector<Setting> more)
{
    std::ranges::move(more, std::back_inserter(to));
}

bool is_port(const Uri& uri)
{
    constexpr std::array<std::string_view, 4> schemes{"serial", "rs485", "pty", "slcan"};
    return std::ranges::find(schemes, uri.scheme) != schemes.end();
}

std::vector<Setting> settings_of(const SlcanLink& link)
{
    const auto flags = slcan::to_words(link.flags());
    return {{"answers", link.has_answered(),
             link.has_answered() ? "the SLCAN adapter answers" : "the SLCAN adapter has never answered"},
            {"flags", flags, flags.empty() ? "" : fmt::format("it reports {}", flags)}};
}

std::vector<Tally> tallies_of(const SlcanLink& link)
{
    using enum Tally::Means;
    const auto& seen = link.counters();
    return {{"refused", "refused by the adapter", seen.refused, trouble},
            {"malformed", "lines without a meaning", seen.malformed, trouble},
            {"foreign", "extended or remote frames", seen.foreign},
            {"overruns", "overruns of the adapter", seen.overruns, loss}};
}

std::vector<Tally> tallies_of(const SocketCanLink& link)
{
    using enum Tally::Means;
    const auto seen = link.counters();
    return {{"error_frames", "error frames", seen.error_frames},
            {"bus_offs", "times bus-off", seen.bus_offs, trouble},
            {"restarts", "restarts of the controller", seen.restarts},
            {"not_acknowledged", "frames that nobody acknowledged", seen.not_acknowledged, trouble},
            {"bus_errors", "errors of bits, stuffing, form or CRC", seen.bus_errors, trouble},
            {"overruns", "overruns of the controller", seen.overruns, loss},
            {"queue_full", "times the interface took no more", seen.queue_full},
            {"lost", "frames lost, not fetched in time", seen.lost, loss}};
}

} // namespace

std::vector<Setting> settings_of(const Adapter& adapter, const DriverSettings& driver, bool wants_rs485)
{
    std::vector<Setting> out;
    if (!adapter.driver.empty())
        out.push_back({"driver", adapter.driver, fmt::format("driver {}", adapter.driver)});
    if (driver.low_latency)
        out.push_back({"low_latency", *driver.low_latency,
                       *driver.low_latency ? "low latency" : "low latency refused by the driver"});
    if (const auto timer = adapter.latency_timer_ms)
        out.push_back({"latency_timer_ms", std::int64_t{*timer}, fmt::format("latency timer {} ms", *timer)});
    if (wants_rs485) {
        const bool switches = driver.rs485.value_or(false);
        out.push_back({"rs485", switches,
                       switches ? "the driver switches the direction"
                                : "the driver does not switch the direction, so the adapter has to"});
    }
    return out;
}

std::vector<Setting> settings_of(const CanInterface& interface)
{
    std::vector<Setting> out;
    if (!interface.kind.empty())
        out.push_back({"kind", interface.kind, fmt::format("kind {}", interface.kind)});
    out.push_back({"state", std::string(to_word(interface.state)), std::string(to_word(interface.state))});
    out.push_back({"tx_queue", std::int64_t{interface.tx_queue}, fmt::format("txqueuelen {}", interface.tx_queue)});
    out.push_back({"restart_ms", std::int64_t{interface.restart_ms},
                   interface.restart_ms == 0 ? "" : fmt::format("restarts after {} ms", interface.restart_ms)});
    out.push_back(
        {"tx_errors", std::int64_t{interface.tx_errors}, fmt::format("{} errors sending", interface.tx_errors)});
    out.push_back(
        {"rx_errors", std::int64_t{interface.rx_errors}, fmt::format("{} errors receiving", interface.rx_errors)});
    return out;
}

std::string to_words(const std::vector<Setting>& settings)
{
    std::string out;
    for (const auto& setting : settings)
        if (!setting.says.empty())
            out += (out.empty() ? "" : ", ") + setting.says;
    return out;
}

Report report_of(const Uri& uri, const AnyLink& link, const Roots& roots)
{
    Report out;
    if (is_port(uri)) {
        const int handle = std::visit([](const auto& one) { return one->handle(); }, link);
        out.settings = settings_of(look_at_adapter(uri.target, roots),
                                   handle >= 0 ? driver_settings(handle) : DriverSettings{}, uri.scheme == "rs485");
    }
    const auto* can = std::get_if<std::unique_ptr<CanLink>>(&link);
    if (can == nullptr)
        return out;
    if (const auto* slcan = dynamic_cast<const SlcanLink*>(can->get())) {
        append(out.settings, settings_of(*slcan));
        out.tallies = tallies_of(*slcan);
    } else if (const auto* socket = dynamic_cast<const SocketCanLink*>(can->get())) {
        if (const auto interface = can_interface(socket->interface()))
            out.settings = settings_of(*interface);
        out.tallies = tallies_of(*socket);
    }
    return out;
}

} // namespace sinew::link
