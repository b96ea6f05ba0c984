#include "apps/cli/link_report.hpp"

#include "sinew/link/slcan.hpp"

namespace sinew::cli {
namespace {

link::SlcanLink* slcan_of(const bus::Bus& bus)
{
    const auto* can = std::get_if<std::unique_ptr<link::CanLink>>(&bus.link());
    return can != nullptr ? dynamic_cast<link::SlcanLink*>(can->get()) : nullptr;
}

void ask_flags(bus::Bus& bus)
{
    if (auto* adapter = slcan_of(bus); adapter == nullptr || !adapter->ask_flags())
        return;
    const TimePoint until = bus.clock().now() + link::slcan_answer_limit;
    for (;;) {
        bus.tend(); // may lose the link, and the adapter with it
        const auto* adapter = slcan_of(bus);
        if (adapter == nullptr || !adapter->flags_are_due() || bus.clock().now() >= until)
            return;
        bus.clock().wait(bus.handles(), until);
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

} // namespace sinew::cli
