#include "apps/cli/forecast.hpp"

#include "sinew/family/broadcast.hpp"
#include "sinew/family/drivers.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

/// A position that the device can be sent to, and what then tells where it is. Some firmware lines want a speed beside
/// it.
std::expected<wire::Requests, Error> position_command(actuator::Driver& driver)
{
    const auto& can = driver.capabilities();
    actuator::Command command{.mode = actuator::Mode::position, .position_rad = 0.0};
    if (can.position_low_rad && can.position_high_rad)
        command.position_rad = (*can.position_low_rad + *can.position_high_rad) / 2;
    auto planned = driver.plan_cycle(command, {});
    if (planned)
        return planned;
    command.velocity_rad_s = 1.0;
    return driver.plan_cycle(command, {});
}

/// Some drivers have to ask a device for a setting once. An answer of zeros brings them to what they do from then on.
void settle(actuator::Driver& driver, const wire::Requests& requests)
{
    actuator::State state;
    for (const auto& asked : requests.all()) {
        wire::Values values;
        for (const auto& value : wire::value_fields(asked.message->reply, asked.options)) {
            const auto range = wire::allowed(*value.field);
            values.add(*value.field, std::clamp<std::int64_t>(0, range.low, range.high));
        }
        if (const auto reply = wire::encode(*asked.message, wire::Direction::reply, asked.id, values, asked.options))
            static_cast<void>(driver.absorb(asked, *reply, {}, state));
    }
}

void add(std::vector<Step>& steps, const Device& device, const wire::Requests& requests)
{
    for (const auto& request : requests.all())
        steps.push_back(step_of(device, request));
}

void add_broadcast(const Family& family, const Device& like, std::vector<Step>& stop)
{
    if (const auto all = stop_of_all(family)) {
        stop.push_back(step_of(like, all->request));
        stop.back().joint = "all";
    }
}

std::vector<wire::Request> with_most(std::span<const Step> steps)
{
    auto out = requests_of(steps);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i].response_time = steps[i].response_most;
    return out;
}

} // namespace

Step step_of(const Device& device, const wire::Request& request)
{
    Step step{device.name, request, device.response_time()};
    // A Nuri is told how long to wait; of the others the documents give what is usual and what may be.
    const auto& time = device.family->response_time;
    step.request.response_time = device.family->name == "nuri" ? step.response_most : time.typical;
    return step;
}

Forecast forecast(const Family& family, std::span<const Device> devices, std::uint32_t bit_rate)
{
    Forecast out{.line = {.can = family.can, .bit_rate = bit_rate}};
    if (!devices.empty())
        add_broadcast(family, devices.front(), out.stop);
    for (const auto& device : devices) {
        if (!device.spec) {
            out.notes.push_back(fmt::format("{} is left out: its model is not known", device.name));
            continue;
        }
        const auto driver = make_driver(*device.spec);
        if (const auto first = driver->plan_read(actuator::Depth::motion))
            settle(*driver, *first);
        const auto look = driver->plan_read(actuator::Depth::motion);
        const auto move = position_command(*driver);
        const auto release = driver->plan({.mode = actuator::Mode::release}, {});
        for (const auto* planned : {&look, &move, &release})
            if (!*planned)
                out.notes.push_back(fmt::format("{}: {}", device.name, to_sentence(planned->error())));
        if (look)
            add(out.look, device, *look);
        if (move)
            add(out.cycle, device, *move);
        if (release)
            add(out.stop, device, *release);
    }
    return out;
}

std::vector<wire::Request> requests_of(std::span<const Step> steps)
{
    std::vector<wire::Request> out;
    for (const auto& step : steps)
        out.push_back(step.request);
    return out;
}

double cycles_per_s(const bus::Line& line, std::span<const Step> steps, bus::Stuffing stuffing)
{
    const Duration cycle = bus::predict_cycle(line, requests_of(steps), stuffing);
    return cycle > Duration{} ? 1.0 / seconds(cycle) : 0.0;
}

bus::StopBound stop_bound(const Forecast& forecast)
{
    return bus::predict_stop(forecast.line, with_most(forecast.cycle), with_most(forecast.stop));
}

Bottleneck bottleneck(const bus::Line& line, std::span<const Step> steps)
{
    auto requests = requests_of(steps);
    const Duration cycle = bus::predict_cycle(line, requests);
    Bottleneck out;
    Duration wire{};
    for (const auto& step : steps) {
        const auto one = bus::predict(line, step.request);
        wire += one.wire();
        if (out.longest == nullptr || one.total() > out.longest_time) {
            out.longest = &step;
            out.longest_time = one.total();
        }
    }
    if (cycle <= Duration{})
        return out;
    const double share = seconds(wire) / seconds(cycle);
    out.responses = share < 0.5;
    out.share = out.responses ? 1.0 - share : share;
    for (auto& request : requests)
        if (out.responses)
            request.response_time = {};
    const bus::Line faster{.can = line.can, .bit_rate = out.responses ? line.bit_rate : 2 * line.bit_rate};
    out.cycles_without = 1.0 / seconds(bus::predict_cycle(faster, requests));
    return out;
}

} // namespace sinew::cli
