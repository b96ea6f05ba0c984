#include "apps/cli/link_report.hpp"

#include "sinew/link/slcan.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

link::SlcanLink* slcan_of(const bus::Bus& bus)
{
    const auto* can = std::get_if<std::unique_ptr<link::CanLink>>(&bus.link());
    return can != nullptr ? dynamic_cast<link::SlcanLink*>(can->get()) : nullptr;
}

constexpr Duration report_period = std::chrono::milliseconds(200);

/// Of an interface without a controller (vcan) nothing is known, and nothing is wrong with that.
bool is_trouble(const link::Setting& setting)
{
    const auto* word = std::get_if<std::string>(&setting.value);
    const auto* count = std::get_if<std::int64_t>(&setting.value);
    if (setting.name == "state")
        return word != nullptr && *word != to_word(link::CanState::error_active) &&
               *word != to_word(link::CanState::unknown);
    if (setting.name == "flags")
        return word != nullptr && !word->empty();
    return (setting.name == "tx_errors" || setting.name == "rx_errors") && count != nullptr && *count != 0;
}

void ask_flags(bus::Bus& bus)
{
    auto* adapter = slcan_of(bus);
    if (adapter == nullptr)
        return;
    const link::FlagsQuestion question(*adapter, bus.clock().now());
    if (!question.is_open())
        return;
    for (;;) {
        bus.tend(); // may lose the link, and the adapter with it
        adapter = slcan_of(bus);
        if (adapter == nullptr || question.is_over(*adapter, bus.clock().now()))
            return;
        bus.clock().wait(bus.handles(), question.until());
    }
}

} // namespace

link::Report report_of(bus::Bus& bus, std::string_view uri)
{
    ask_flags(bus);
    const auto parsed = link::parse_uri(uri);
    return parsed ? link::report_of(*parsed, bus.link()) : link::Report{};
}

Json report_json(const link::Report& report)
{
    Json settings = Json::object(), counters = Json::object();
    for (const auto& setting : report.settings)
        settings.set(setting.name, std::visit([](const auto& value) { return Json(value); }, setting.value));
    for (const auto& tally : report.tallies)
        counters.set(tally.name, static_cast<std::int64_t>(tally.count));
    return Json::object({{"settings", std::move(settings)}, {"counters", std::move(counters)}});
}

std::string troubles_of(const link::Report& report)
{
    std::vector<std::string> all;
    for (const auto& setting : report.settings)
        if (is_trouble(setting))
            all.push_back(setting.says);
    for (const auto& tally : report.tallies)
        if (tally.count != 0)
            all.push_back(fmt::format("{} {}", tally.count, tally.says));
    return fmt::format("{}", fmt::join(all, ", "));
}

void LinkReports::look(Session& session)
{
    const TimePoint now = session.clock().now();
    const bool is_due = !looked_ || now - *looked_ >= report_period;
    if (is_due)
        looked_ = now;
    for (auto* bus : session.buses()) {
        if (is_due && bus->link_trouble() == nullptr)
            all_[bus] = report_of(*bus, bus->name());
        if (bus->link_trouble() != nullptr) // its link may have been lost while it was asked
            all_.erase(bus);
    }
}

const link::Report* LinkReports::of(const bus::Bus& bus) const
{
    const auto found = all_.find(&bus);
    return found != all_.end() && !found->second.tallies.empty() ? &found->second : nullptr;
}

} // namespace sinew::cli
