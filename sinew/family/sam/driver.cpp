#include "sinew/family/sam/driver.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sam {
namespace {

constexpr double full_duty = 1000.0;         // 0.1 % a unit (L724)
constexpr int counter_clockwise_zero = 1000; // L726
constexpr int fastest_clockwise = 999;       // L726: clockwise ends at 99.9 % (S41)

/// The finest coordinates of a model.
const PositionScale& finest(const Model& model)
{
    return model.precise ? *model.precise : model.standard;
}

/// If `asked` is an M, its answer goes to `use`.
template <class M, class Use>
bool take(const wire::Request& asked, const wire::Frame& reply, std::expected<void, Error>& result, const Use& use)
{
    if (asked.message != &wire::info_of<M>)
        return false;
    if (const auto answer = wire::decode_reply<M>(reply, asked.options))
        use(answer->message);
    else
        result = std::unexpected(answer.error());
    return true;
}

} // namespace

Driver::Driver(const Spec& spec) : spec_(spec)
{
    const PositionScale& scale = finest(*spec_.model);
    can_.position_low_rad = scale.rad(static_cast<double>(scale.control.low));
    can_.position_high_rad = scale.rad(static_cast<double>(scale.control.high));
    can_.position_step_rad = units::rad(scale.deg_per_unit);
    can_.velocity_max_rad_s = spec_.model->ratings.max_speed_rad_s;
    can_.velocity = true;
    can_.measures_velocity = can_.measures_current = can_.measures_voltage = true;
}

template <class M>
std::expected<void, Error> Driver::add(wire::Requests& out, const M& message) const
{
    auto request = wire::make_request(spec_.id, message, spec_.profile.options());
    if (!request)
        return std::unexpected(std::move(request.error()));
    request->answered = spec_.profile.answers(*request->message);
    out.add(*request);
    return {};
}

std::expected<void, Error> Driver::go_to(wire::Requests& out, double position_rad) const
{
    const PositionScale& scale = finest(*spec_.model);
    const auto raw =
        std::clamp<std::int64_t>(std::llround(scale.raw(position_rad)), scale.control.low, scale.control.high);
    if (spec_.model->precise)
        return add(out, PrecisePositionControl{.target_position = static_cast<std::uint32_t>(raw)});
    return add(out, PositionControl{.target_position = static_cast<std::uint16_t>(raw)});
}

std::expected<void, Error> Driver::turn(wire::Requests& out, double velocity_rad_s) const
{
    const double share = std::abs(velocity_rad_s) / spec_.model->ratings.max_speed_rad_s;
    const int duty = static_cast<int>(std::lround(share * full_duty));
    const bool clockwise = (velocity_rad_s >= 0.0) == spec_.profile.clockwise_positive;
    const int wheel_speed = clockwise || duty == 0 ? std::min(duty, fastest_clockwise) : counter_clockwise_zero + duty;
    return add(out, SpecialControl{.mode = Mode::wheel, .wheel_speed = static_cast<std::uint16_t>(wheel_speed)});
}

std::expected<wire::Requests, Error> Driver::plan(const actuator::Command& command, const actuator::State& state)
{
    if (auto fine = actuator::check(command, can_, spec_.id); !fine)
        return std::unexpected(std::move(fine.error()));
    wire::Requests out;
    std::expected<void, Error> added;
    switch (command.mode) {
    case actuator::Mode::hold:
        // A position command is the only one that holds (L408), and it needs to know where.
        if (!state.position_rad)
            return fail(Errc::unsupported, "to hold, a SAM must be told its own position; read its state first");
        added = go_to(out, *state.position_rad);
        break;
    case actuator::Mode::release:
        added = add(out, SpecialControl{.mode = Mode::passive});
        break;
    case actuator::Mode::position:
        added = go_to(out, *command.position_rad);
        break;
    case actuator::Mode::velocity:
        added = turn(out, *command.velocity_rad_s);
        break;
    }
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

std::expected<wire::Requests, Error> Driver::plan_read(actuator::Depth depth)
{
    if (spec_.profile.response_level > 1)
        return fail(Errc::unsupported, "the device is set to answer nothing (response level 2); it cannot be read");
    wire::Requests out;
    auto added = spec_.model->precise ? add(out, ReadPrecisePosition{}) : add(out, ReadCurrentPosition{});
    if (added && depth == actuator::Depth::full) {
        added = add(out, ReadCurrentSpeed{});
        for (const auto& next :
             {add(out, ReadCurrentLoad{}), add(out, ReadInputVoltage{}), add(out, ReadTemperatureError{})})
            if (!next)
                added = next;
    }
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

std::expected<void, Error> Driver::absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                          actuator::State& state)
{
    const Model& model = *spec_.model;
    const auto standard_position = [&](const Position& p) { state.position_rad = model.standard.rad(p.position); };
    const auto precise_position = [&](const PrecisePosition& p) {
        if (model.precise)
            state.position_rad = model.precise->rad(p.position);
    };
    const auto quick_state = [&](const QuickState& s) {
        state.position_rad = model.quick.rad(s.position);
        state.current_a = s.load * model.current_a_per_ad8;
    };
    const auto speed = [&](const CurrentSpeed& s) {
        state.velocity_rad_s = units::rad(s.current_speed * model.speed_deg_s_per_unit);
    };
    const auto load = [&](const CurrentLoad& l) { state.current_a = l.current_load * model.current_a_per_ad12; };
    const auto voltage = [&](const InputVoltage& v) {
        state.voltage_v = v.input_voltage * model.voltage_v_per_ad + model.voltage_offset_v;
    };
    const auto overheat = [&](const TemperatureError& t) {
        state.faults = actuator::Faults{};
        state.raw_faults = t.temp_error;
        if (t.temp_error != 0)
            state.faults->set(actuator::Fault::over_temperature);
    };
    std::expected<void, Error> result;
    const bool tells = take<ReadPrecisePosition>(asked, reply, result, precise_position) ||
                       take<PrecisePositionControl>(asked, reply, result, precise_position) ||
                       take<ReadCurrentPosition>(asked, reply, result, standard_position) ||
                       take<PositionControl>(asked, reply, result, standard_position) ||
                       take<QuickReadStatus>(asked, reply, result, quick_state) ||
                       take<QuickPositionControl>(asked, reply, result, quick_state) ||
                       take<ReadCurrentSpeed>(asked, reply, result, speed) ||
                       take<ReadCurrentLoad>(asked, reply, result, load) ||
                       take<ReadInputVoltage>(asked, reply, result, voltage) ||
                       take<ReadTemperatureError>(asked, reply, result, overheat);
    if (tells && result)
        state.at = at;
    return result;
}

} // namespace sinew::sam
