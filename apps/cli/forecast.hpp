#pragma once
#include "apps/cli/adapter_port.hpp"
#include "apps/cli/bus_target.hpp"
#include "sinew/bus/predict.hpp"

/// What a bus with its joints has to carry, and what its wire allows.
namespace sinew::cli {

/// One request and its response time: of a cycle that which its device usually takes, of a stop that which the bus
/// gives it.
struct Step {
    std::string joint;
    wire::Request request;
    Duration response_most{}; ///< that its device may take
};

struct Forecast {
    bus::Line line;
    AdapterPort port;               ///< before it
    std::vector<Step> look;         ///< what reads the motion of every joint
    std::vector<Step> cycle;        ///< a position for every joint, and what it measures: a cycle of `robot::Robot`
    std::vector<Step> most;         ///< all that such a cycle may carry; see `robot::Load`
    std::vector<Step> stop;         ///< what its policy sends when it stops, at most
    std::vector<std::string> notes; ///< joints that are left out, and why
};

/// From what the drivers plan, and of the joints of a robot file from what their robot sends. Devices without a model
/// are left out.
Forecast forecast(const Family& family, std::span<const Device> devices, std::uint32_t bit_rate);

/// A step of a request that the device was not asked to plan.
Step step_of(const Device& device, const wire::Request& request);

std::vector<wire::Request> requests_of(std::span<const Step> steps);

/// How often in a second a cycle of this forecast fits, at the stuffing that is named.
double cycles_per_s(const Forecast& forecast, std::span<const Step> steps, bus::Stuffing stuffing);

/// How late a stop is at worst, whatever the cycle carries.
bus::StopBound stop_bound(const Forecast& forecast);

/// What a cycle spends most of its time on, and what it would be without.
struct Bottleneck {
    enum class By : std::uint8_t { bits, responses, port } by{}; ///< port: the text on the line to the adapter
    double share = 0.0;                                          ///< of the time of a cycle
    double cycles_without = 0.0;   ///< per second: no response times, twice the bit rate, or a port without a limit
    const Step* longest = nullptr; ///< the longest exchange
    Duration longest_time{};
};
Bottleneck bottleneck(const Forecast& forecast, std::span<const Step> steps);

} // namespace sinew::cli
