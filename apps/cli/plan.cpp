#include "apps/cli/exit_codes.hpp"
#include "apps/cli/forecast.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/present.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using bus::Stuffing;

/// Requests of one kind, of however many joints.
struct Kind {
    const Step* step = nullptr;
    std::size_t count = 0;
};

std::vector<Kind> kinds_of(std::span<const Step> steps)
{
    std::vector<Kind> out;
    for (const auto& step : steps) {
        const auto same = std::ranges::find_if(out, [&](const Kind& kind) {
            const auto& known = kind.step->request;
            return known.message == step.request.message && known.response_time == step.request.response_time &&
                   known.answered == step.request.answered;
        });
        if (same != out.end())
            ++same->count;
        else
            out.push_back({&step, 1});
    }
    return out;
}

std::int64_t bits_out(const bus::Line& line, const wire::Request& request, Stuffing stuffing = Stuffing::most)
{
    return bus::frame_bits(line.can, request.frame.size, stuffing);
}

std::int64_t bits_back(const bus::Line& line, const wire::Request& request, Stuffing stuffing = Stuffing::most)
{
    const int replies = bus::reply_count(request);
    return replies == 0 ? 0 : replies * bus::frame_bits(line.can, request.message->reply.size, stuffing);
}

std::string time_text(Duration time)
{
    const double us = seconds(time) * 1e6;
    return us < 1000.0 ? fmt::format("{:.0f} us", us) : fmt::format("{:.2f} ms", us / 1000.0);
}

/// From the longest frames to the shortest: on a serial line these are the same.
std::string rate_text(const Forecast& plan, std::span<const Step> steps)
{
    const double least = cycles_per_s(plan, steps, Stuffing::most);
    const double most = cycles_per_s(plan, steps, Stuffing::least);
    return least < most ? fmt::format("{:.0f} to {:.0f} times a second", least, most)
                        : fmt::format("{:.0f} times a second", least);
}

Json step_json(const bus::Line& line, const Step& step)
{
    const auto one = bus::predict(line, step.request);
    return Json::object({{"joint", step.joint},
                         {"message", step.request.message->name()},
                         {"request_bits", bits_out(line, step.request)},
                         {"reply_bits", bits_back(line, step.request)},
                         {"response_s", seconds(one.response)},
                         {"exchange_s", seconds(one.total())}});
}

Json work_json(const Forecast& plan, std::span<const Step> steps)
{
    Json list = Json::array();
    for (const auto& step : steps)
        list.add(step_json(plan.line, step));
    return Json::object({{"cycles_per_s", cycles_per_s(plan, steps, Stuffing::most)},
                         {"cycles_per_s_without_stuff_bits", cycles_per_s(plan, steps, Stuffing::least)},
                         {"exchanges", std::move(list)}});
}

std::string_view to_word(Bottleneck::By by)
{
    return by == Bottleneck::By::port ? "port" : by == Bottleneck::By::responses ? "response_time" : "bit_rate";
}

Json to_json(const BusTarget& bus, const Forecast& plan)
{
    const auto limit = bottleneck(plan, plan.cycle);
    const auto bound = stop_bound(plan);
    Json notes = Json::array();
    for (const auto& note : plan.notes)
        notes.add(note);
    return Json::object(
        {{"bus", bus.name},
         {"family", bus.family->name},
         {"bit_rate", plan.line.bit_rate},
         {"joints", static_cast<std::int64_t>(bus.devices.size())},
         {"read", work_json(plan, plan.look)},
         {"move_and_read", work_json(plan, plan.cycle)},
         {"limit", Json::object({{"by", to_word(limit.by)},
                                 {"share", limit.share},
                                 {"cycles_per_s_without", limit.cycles_without},
                                 {"longest_joint", limit.longest != nullptr ? Json(limit.longest->joint) : Json()},
                                 {"longest_message",
                                  limit.longest != nullptr ? Json(limit.longest->request.message->name()) : Json()},
                                 {"longest_s", seconds(limit.longest_time)}})},
         {"stop", Json::object({{"begins_s", seconds(bound.begins)},
                                {"first_frame_s", seconds(bound.first)},
                                {"ends_s", seconds(bound.ends)}})},
         {"notes", std::move(notes)}});
}

std::string limit_text(const Forecast& plan)
{
    const auto limit = bottleneck(plan, plan.cycle);
    const auto what = limit.by == Bottleneck::By::port
                          ? fmt::format("the serial line to the adapter, which carries every frame as text: at more "
                                        "than {} baud it would be {:.0f} a second",
                                        plan.port.baud, limit.cycles_without)
                      : limit.by == Bottleneck::By::responses
                          ? fmt::format("the devices: {:.0f} % of a cycle are response times; without them it would be "
                                        "{:.0f} a second",
                                        100.0 * limit.share, limit.cycles_without)
                          : fmt::format("the bit rate: {:.0f} % of a cycle are bits; at twice the rate it would be "
                                        "{:.0f} a second",
                                        100.0 * limit.share, limit.cycles_without);
    return fmt::format("{}. The longest exchange is {} of {}, {}.", what, limit.longest->request.message->name(),
                       limit.longest->joint, time_text(limit.longest_time));
}

void print_paragraph(std::string_view name, const std::string& text)
{
    constexpr std::size_t indent = 17;
    fmt::print("  {:<13}  {}\n", name, wrap(text, indent, columns()));
}

void print_text(const BusTarget& bus, const Forecast& plan)
{
    fmt::print("{}  {}, {} bps, {} {}\n", bold(bus.name), bus.family->name, plan.line.bit_rate, bus.devices.size(),
               bus.devices.size() == 1 ? "joint" : "joints");
    Table table({"MESSAGE", "COUNT", "BITS OUT", "BITS BACK", "RESPONSE", "EXCHANGE"});
    for (const auto& [step, count] : kinds_of(plan.cycle)) {
        const auto one = bus::predict(plan.line, step->request);
        table.add({std::string(step->request.message->name()), std::to_string(count),
                   std::to_string(bits_out(plan.line, step->request)),
                   std::to_string(bits_back(plan.line, step->request)), time_text(one.response),
                   time_text(one.total())});
    }
    fmt::print("{}", table.text(2));
    if (!plan.look.empty())
        print_paragraph("read all", rate_text(plan, plan.look));
    if (!plan.cycle.empty()) {
        print_paragraph("move and read", rate_text(plan, plan.cycle));
        print_paragraph("limit", limit_text(plan));
    }
    if (!plan.stop.empty()) {
        const auto bound = stop_bound(plan);
        const bool broadcast = plan.stop.front().joint == "all";
        print_paragraph("stop",
                        fmt::format("begins within {}, {} by {}, every joint was told by {}", time_text(bound.begins),
                                    broadcast ? "all have heard the broadcast" : "the first joint was told",
                                    time_text(bound.first), time_text(bound.ends)));
    }
    for (const auto& note : plan.notes)
        print_paragraph("note", note);
    fmt::print("\n");
}

Outcome run(const Words& words)
{
    const auto path = words.text("ROBOT") ? words.text("ROBOT") : robot_path(words);
    if (!path)
        return fail(Errc::bad_argument, "which robot? Name its file, such as sinew plan robots/demo.toml");
    const auto buses = buses_of(*path);
    if (!buses)
        return std::unexpected(buses.error());
    if (buses->empty())
        return fail(Errc::bad_file, fmt::format("{} has no joints to plan for", *path));
    Json out = Json::array();
    for (const auto& bus : *buses) {
        auto plan = forecast(*bus.family, bus.devices, bus.bit_rate);
        if (plan.port.is_slcan && plan.port.baud == 0)
            plan.notes.emplace_back(
                "its adapter is taken for one that is USB all the way; one on a serial line carries "
                "less: tell its rate with baud=RATE in the link");
        if (words.json())
            out.add(to_json(bus, plan));
        else
            print_text(bus, plan);
    }
    if (words.json())
        print(out);
    return exit_done;
}

} // namespace

Verb plan_verb()
{
    return {.name = "plan",
            .says =
                "What the wires of a robot allow: how often its joints can be moved and read, and how late a stop is.",
            .arguments = {{"ROBOT", "its robot file, where SINEW_ROBOT does not say it", false}},
            .options = {json_option},
            .examples = {{"sinew plan robots/demo.toml", "each bus; nothing is opened"}},
            .run = run,
            .more = "Computed from the rows of the messages alone: bits on the wire, and the response times of the "
                    "devices. The host's own time is not in it; sinew bus --measure measures with it. A CAN frame has "
                    "stuff bits that depend on what it carries, so its figures are a range. "
                    "An SLCAN adapter carries no more than the baud=RATE of its link.",
            .ends = {exit_refused}};
}

} // namespace sinew::cli
