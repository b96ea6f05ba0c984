#include "sinew/family/sam/driver.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"
#include "sinew/family/sam/messages.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sam {
namespace {

constexpr double full_duty = 1000.0;         // 0.1 % a unit (L724)
constexpr int counter_clockwise_zero = 1000; // L726
constexpr double most_duty = 0.999;          // L726: what both directions have (S41)
constexpr Range quick_ids{0, 30};            // L306
constexpr std::uint8_t strongest = 0;        // L392

constexpr std::string_view no_speed =
    "the protocol has no documented speed for a move to a position; leave it out, or send positions in small steps";
constexpr std::string_view no_current = "the protocol has no command for a current, only stored limits of torque";

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
    const PositionScale& fine = finest();
    can_.position_low_rad = fine.rad(static_cast<double>(fine.control.low));
    can_.position_high_rad = fine.rad(static_cast<double>(fine.control.high));
    can_.position_step_rad = units::rad(fine.deg_per_unit);
    can_.velocity_max_rad_s = most_duty * spec_.model->ratings.max_speed_rad_s;
    can_.velocity = can_.brake = can_.duty = actuator::able;
    can_.velocity_is_duty = true;
    can_.duty_max = most_duty;
    can_.velocity_limit.why_not = can_.timed.why_not = no_speed;
    can_.timed_velocity.why_not = "the wheel turns at its duty at once";
    can_.current.why_not = can_.current_limit.why_not = can_.torque.why_not = no_current;
    can_.measures_velocity = can_.measures_current = can_.measures_voltage = can_.measures_faults = true;
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

// ---- coordinates ----

const PositionScale& Driver::finest() const
{
    return spec_.model->precise ? *spec_.model->precise : spec_.model->standard;
}

bool Driver::can_be(const PositionScale& scale, double resolution_rad) const
{
    const bool addressed = &scale != &spec_.model->quick || quick_ids.contains(spec_.id);
    return addressed && units::rad(scale.deg_per_unit) <= resolution_rad;
}

const PositionScale& Driver::scale_for(double position_rad, double resolution_rad) const
{
    // In the order of their length on the wire.
    for (const auto* scale : {&spec_.model->quick, &spec_.model->standard})
        if (can_be(*scale, resolution_rad) && scale->control.contains(std::llround(scale->raw(position_rad))))
            return *scale;
    return finest();
}

// ---- commands ----

std::expected<void, Error> Driver::go_to(wire::Requests& out, double position_rad, double resolution_rad) const
{
    const PositionScale& scale = scale_for(position_rad, resolution_rad);
    // Only hold is ever further out than rounding goes.
    const auto raw =
        std::clamp<std::int64_t>(std::llround(scale.raw(position_rad)), scale.control.low, scale.control.high);
    if (&scale == &spec_.model->quick)
        return add(out,
                   QuickPositionControl{.torque_level = strongest, .target_position = static_cast<std::uint8_t>(raw)});
    if (&scale == &spec_.model->standard)
        return add(out, PositionControl{.target_position = static_cast<std::uint16_t>(raw)});
    return add(out, PrecisePositionControl{.target_position = static_cast<std::uint32_t>(raw)});
}

std::expected<void, Error> Driver::wheel(wire::Requests& out, double duty) const
{
    const int steps = static_cast<int>(std::lround(std::abs(duty) * full_duty));
    const bool clockwise = (duty >= 0.0) == spec_.profile.clockwise_positive;
    const int wheel_speed = clockwise || steps == 0 ? steps : counter_clockwise_zero + steps;
    return add(out, SpecialControl{.mode = Mode::wheel, .wheel_speed = static_cast<std::uint16_t>(wheel_speed)});
}

std::expected<void, Error> Driver::carry_out(wire::Requests& out, const actuator::Command& command,
                                             const actuator::State& state) const
{
    switch (command.mode) {
    case actuator::Mode::hold:
        // A position command is the only one that holds (L408), and it needs to know where.
        if (!state.position_rad)
            return actuator::refuse(Errc::unsupported, spec_.id,
                                    "to hold, a SAM must be told its own position; read its state first");
        return go_to(out, *state.position_rad, 0.0);
    case actuator::Mode::release:
        return add(out, SpecialControl{.mode = Mode::passive});
    case actuator::Mode::brake:
        // Not the quick one, which by one of its descriptions brakes the whole line (S25).
        return add(out, SpecialControl{.mode = Mode::brake});
    case actuator::Mode::position:
        return go_to(out, *command.position_rad, command.resolution_rad.value_or(0.0));
    case actuator::Mode::velocity:
        return wheel(out, *command.velocity_rad_s / spec_.model->ratings.max_speed_rad_s);
    case actuator::Mode::duty:
        return wheel(out, *command.duty);
    case actuator::Mode::current:
    case actuator::Mode::torque:
        break; // refused by `check`
    }
    return {};
}

std::expected<wire::Requests, Error> Driver::plan(const actuator::Command& command, const actuator::State& state)
{
    if (auto fine = actuator::check(command, can_, spec_.id); !fine)
        return std::unexpected(std::move(fine.error()));
    wire::Requests out;
    if (auto added = carry_out(out, command, state); !added)
        return std::unexpected(std::move(added.error()));
    return out;
}

// ---- reading ----

std::expected<void, Error> Driver::read_position(wire::Requests& out, double resolution_rad) const
{
    if (spec_.profile.response_level > 1)
        return actuator::refuse(Errc::unsupported, spec_.id,
                                "the device is set to answer nothing (response level 2); it cannot be read");
    if (can_be(spec_.model->quick, resolution_rad))
        return add(out, QuickReadStatus{});
    if (can_be(spec_.model->standard, resolution_rad) || !spec_.model->precise)
        return add(out, ReadCurrentPosition{});
    return add(out, ReadPrecisePosition{});
}

std::expected<wire::Requests, Error> Driver::plan_read(actuator::Depth depth, double resolution_rad)
{
    wire::Requests out;
    auto added = read_position(out, resolution_rad);
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

std::expected<wire::Requests, Error> Driver::plan_cycle(const actuator::Command& command, const actuator::State& state)
{
    auto out = plan(command, state);
    if (!out)
        return out;
    const auto& last = out->all().back();
    const bool tells = last.answered && last.message != &wire::info_of<SpecialControl>;
    if (tells)
        return out;
    if (auto added = read_position(*out, command.resolution_rad.value_or(0.0)); !added)
        return std::unexpected(std::move(added.error()));
    return out;
}

bool Driver::absorb_motion(const wire::Request& asked, const wire::Frame& reply, TimePoint at, actuator::State& state,
                           std::expected<void, Error>& result) const
{
    const Model& model = *spec_.model;
    const auto standard_position = [&](const Position& p) {
        state.position_rad = {model.standard.rad(p.position), at};
    };
    const auto precise_position = [&](const PrecisePosition& p) {
        if (model.precise)
            state.position_rad = {model.precise->rad(p.position), at};
    };
    const auto quick_state = [&](const QuickState& s) {
        state.position_rad = {model.quick.rad(s.position), at};
        state.current_a = {s.load * model.current_a_per_ad8, at};
    };
    return take<PrecisePositionControl>(asked, reply, result, precise_position) ||
           take<ReadPrecisePosition>(asked, reply, result, precise_position) ||
           take<PositionControl>(asked, reply, result, standard_position) ||
           take<ReadCurrentPosition>(asked, reply, result, standard_position) ||
           take<QuickPositionControl>(asked, reply, result, quick_state) ||
           take<QuickReadStatus>(asked, reply, result, quick_state);
}

std::expected<void, Error> Driver::absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                          actuator::State& state)
{
    const Model& model = *spec_.model;
    const auto speed = [&](const CurrentSpeed& s) {
        state.velocity_rad_s = {units::rad(s.current_speed * model.speed_deg_s_per_unit), at};
    };
    const auto load = [&](const CurrentLoad& l) { state.current_a = {l.current_load * model.current_a_per_ad12, at}; };
    const auto voltage = [&](const InputVoltage& v) {
        state.voltage_v = {v.input_voltage * model.voltage_v_per_ad + model.voltage_offset_v, at};
    };
    const auto overheat = [&](const TemperatureError& t) {
        actuator::Faults faults;
        if (t.temp_error != 0)
            faults.set(actuator::Fault::over_temperature);
        state.faults = {faults, at};
        state.raw_faults = t.temp_error;
    };
    std::expected<void, Error> result;
    const bool tells =
        absorb_motion(asked, reply, at, state, result) || take<ReadCurrentSpeed>(asked, reply, result, speed) ||
        take<ReadCurrentLoad>(asked, reply, result, load) || take<ReadInputVoltage>(asked, reply, result, voltage) ||
        take<ReadTemperatureError>(asked, reply, result, overheat);
    if (tells && result)
        state.at = at;
    if (!tells)
        absorb_gains(asked, reply, result);
    return result;
}

// ---- run-time settings ----

bool Driver::absorb_gains(const wire::Request& asked, const wire::Frame& reply, std::expected<void, Error>& result)
{
    const Runtime& own = spec_.runtime;
    const auto differ = [&](bool differs) {
        if (set_ && differs)
            reset_ = "its gains are not those that were set";
    };
    return take<ReadPdGain>(asked, reply, result,
                            [&](const PdGain& g) {
                                differ((own.p_gain && *own.p_gain != g.p_gain) ||
                                       (own.d_gain && *own.d_gain != g.d_gain));
                            }) ||
           take<ReadIGain>(asked, reply, result,
                           [&](const IGain& g) { differ(own.i_gain && *own.i_gain != g.i_gain); });
}

std::expected<wire::Requests, Error> Driver::plan_settings()
{
    const Runtime& own = spec_.runtime;
    wire::Requests out;
    std::expected<void, Error> added;
    if (own.p_gain.has_value() != own.d_gain.has_value())
        return actuator::refuse(Errc::missing_field, spec_.id, "the P and D gains travel together; give both");
    if (own.p_gain)
        added = add(out, SetRuntimePdGain{.p_gain = *own.p_gain, .d_gain = *own.d_gain});
    if (added && own.i_gain)
        added = add(out, SetRuntimeIGain{.i_gain = *own.i_gain});
    if (!added)
        return std::unexpected(std::move(added.error()));
    set_ = !out.empty();
    reset_ = {};
    return out;
}

std::expected<wire::Requests, Error> Driver::plan_reset_check()
{
    wire::Requests out;
    if (!set_ || spec_.profile.response_level > 1)
        return out;
    std::expected<void, Error> added;
    if (spec_.runtime.p_gain)
        added = add(out, ReadPdGain{});
    if (added && spec_.runtime.i_gain)
        added = add(out, ReadIGain{});
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

} // namespace sinew::sam
