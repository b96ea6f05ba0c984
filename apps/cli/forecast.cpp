#include "apps/cli/forecast.hpp"

#include "sinew/family/drivers.hpp"
#include "sinew/robot/load.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

void add(std::vector<Step>& steps, const Device& device, const wire::Requests& requests)
{
    for (const auto& request : requests.all())
        steps.push_back(step_of(device, request));
}

/// As the bus waits for them.
std::vector<Step> steps_of(std::span<const robot::Load::Part> parts)
{
    std::vector<Step> out;
    for (const auto& part : parts)
        out.push_back({part.joint, part.request, part.request.response_time});
    return out;
}

void add_load(Forecast& out, std::span<const Device> devices)
{
    const auto& one = devices.front();
    const auto load = robot::load_of(*one.file, one.joint->bus.value, out.line);
    if (!load) {
        out.notes.push_back(to_sentence(load.error()));
        return;
    }
    for (const auto& part : load->cycle)
        out.cycle.push_back(step_of(*std::ranges::find(devices, part.joint, &Device::name), part.request));
    out.most = steps_of(load->most);
    out.stop = steps_of(load->stop);
    out.notes.insert(out.notes.end(), load->notes.begin(), load->notes.end());
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
        out.port = adapter_port_of(devices.front().link);
    for (const auto& device : devices) {
        if (!device.spec) {
            out.notes.push_back(fmt::format("{} is left out: its model is not known", device.name));
            continue;
        }
        const auto driver = make_driver(*device.spec);
        actuator::State state;
        robot::settle(*driver, state);
        const auto look = driver->plan_read(actuator::Depth::motion);
        if (look)
            add(out.look, device, *look);
        else
            out.notes.push_back(fmt::format("{}: {}", device.name, to_sentence(look.error())));
    }
    if (!devices.empty() && devices.front().joint != nullptr)
        add_load(out, devices);
    return out;
}

std::vector<wire::Request> requests_of(std::span<const Step> steps)
{
    std::vector<wire::Request> out;
    for (const auto& step : steps)
        out.push_back(step.request);
    return out;
}

double cycles_per_s(const Forecast& forecast, std::span<const Step> steps, bus::Stuffing stuffing)
{
    const auto requests = requests_of(steps);
    const Duration cycle =
        std::max(bus::predict_cycle(forecast.line, requests, stuffing), time_on_port(forecast.port, requests));
    return cycle > Duration{} ? 1.0 / seconds(cycle) : 0.0;
}

/// Where nothing goes to all, which frame goes first depends on what the joints do then: no longer than any of theirs.
bus::StopBound stop_bound(const Forecast& forecast)
{
    const auto running = requests_of(forecast.most), stop = requests_of(forecast.stop);
    auto bound = bus::predict_stop(forecast.line, running, stop);
    for (const auto& step : forecast.stop)
        if (forecast.stop.front().joint != "all")
            bound.first = std::max(bound.first, bound.begins + bus::predict(forecast.line, step.request).request);
    return on_port(forecast.port, bound, running, stop);
}

Bottleneck bottleneck(const Forecast& forecast, std::span<const Step> steps)
{
    const bus::Line& line = forecast.line;
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
    if (time_on_port(forecast.port, requests) > cycle) {
        out.by = Bottleneck::By::port;
        out.share = 1.0;
        out.cycles_without = 1.0 / seconds(cycle);
        return out;
    }
    const double share = seconds(wire) / seconds(cycle);
    const bool responses = share < 0.5;
    out.by = responses ? Bottleneck::By::responses : Bottleneck::By::bits;
    out.share = responses ? 1.0 - share : share;
    for (auto& request : requests)
        if (responses)
            request.response_time = {};
    const bus::Line faster{.can = line.can, .bit_rate = responses ? line.bit_rate : 2 * line.bit_rate};
    out.cycles_without = 1.0 / seconds(bus::predict_cycle(faster, requests));
    return out;
}

} // namespace sinew::cli
