#include "sinew/base/units.hpp"
#include "sinew/family/rmd/driver.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/wire/select.hpp"

#include <cmath>

namespace sinew::rmd {
namespace {

constexpr std::int64_t motor_is_on = 0x00; // of motor_state, LK lines
constexpr std::int64_t brake_is_free = 1;  // of brake-control, LK lines
/// A control loop asks for the angle again after so many turns, to check what the encoder says.
constexpr int cycles_between_angles = 256;
constexpr double rest_deg_s = 2.0;
constexpr double turn_deg = 360.0;
constexpr double same_angle_deg = 2.0;

struct ErrorBit {
    std::int64_t bit;
    actuator::Fault fault;
};
constexpr ErrorBit two_bits[] = {{1, actuator::Fault::low_voltage}, {8, actuator::Fault::over_temperature}};
constexpr ErrorBit eight_bits[] = {{1, actuator::Fault::low_voltage},
                                   {2, actuator::Fault::high_voltage},
                                   {4, actuator::Fault::driver_over_temperature},
                                   {8, actuator::Fault::over_temperature},
                                   {16, actuator::Fault::over_current},
                                   {32, actuator::Fault::short_circuit},
                                   {64, actuator::Fault::stall},
                                   {128, actuator::Fault::input_lost}};

std::span<const ErrorBit> error_bits(ErrorBits kind)
{
    switch (kind) {
    case ErrorBits::two:
        return two_bits;
    case ErrorBits::eight:
        return eight_bits;
    case ErrorBits::sixteen:
        break;
    }
    return {};
}

} // namespace

// ---- reading ----

std::expected<wire::Requests, Error> Driver::plan_read(actuator::Depth depth, double)
{
    wire::Requests out;
    auto added = add(out, "read-multi-turn-angle");
    if (added)
        added = add(out, "read-status2");
    if (added && depth == actuator::Depth::full)
        added = add(out, "read-status1");
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

std::expected<wire::Requests, Error> Driver::plan_cycle(const actuator::Command& command, const actuator::State& state)
{
    auto out = plan(command, state);
    if (!out)
        return out;
    const bool tells = wire::find_field(out->all().back().message->reply, "encoder") != nullptr;
    if (tells && track_.follows() && ++cycles_ < cycles_between_angles)
        return out;
    cycles_ = 0;
    if (auto added = add(*out, "read-multi-turn-angle"); !added)
        return std::unexpected(std::move(added.error()));
    return out;
}

double Driver::physical(const wire::MessageInfo& message, const wire::Value& value) const
{
    const auto model = std::span(spec_.overrides).first(spec_.override_count);
    return wire::reading(message, *value.field, spec_.profile.line.overrides, model).physical(value.raw);
}

void Driver::absorb_faults(std::int64_t raw, TimePoint at, actuator::State& state) const
{
    actuator::Faults faults;
    std::int64_t explained = 0;
    for (const ErrorBit& known : error_bits(spec_.profile.error_bits)) {
        explained |= known.bit;
        if ((raw & known.bit) != 0)
            faults.set(known.fault);
    }
    if ((raw & ~explained) != 0)
        faults.set(actuator::Fault::unexplained);
    state.faults = {faults, at};
    state.raw_faults = static_cast<std::uint32_t>(raw);
}

void Driver::absorb_switch(bool off, TimePoint at, actuator::State& state)
{
    // A motor is on after power-up (field notes 1).
    if (!off && said_off_)
        notice("it is on although it was switched off");
    if (off && !off_) // by another program
        forget_turns();
    off_ = said_off_ = off;
    state.enabled = {!off, at};
}

/// After power-up the angle begins within one turn (R38), and nobody turned the shaft.
void Driver::look_for_lost_turns(double deg)
{
    if (angle_deg_ && rested_ && rests_) {
        const double lost = deg - *angle_deg_;
        const double turns = std::round(lost / turn_deg);
        const bool whole = turns != 0.0 && std::abs(lost - turns * turn_deg) <= same_angle_deg;
        const bool first = deg > -same_angle_deg && deg < turn_deg + same_angle_deg;
        const bool sent_there = target_deg_ && std::abs(deg - *target_deg_) < turn_deg / 2.0;
        if (whole && first && !sent_there)
            notice_lost_turns();
    }
    angle_deg_ = deg;
    rested_ = rests_;
}

void Driver::absorb_angle(double deg, TimePoint at, actuator::State& state)
{
    look_for_lost_turns(deg);
    track_.angle(deg, at);
    state.position_rad = {output_rad(deg), at};
    state.at = at;
}

void Driver::absorb_motion(const wire::MessageInfo& message, const wire::Values& values, TimePoint at,
                           actuator::State& state)
{
    state.at = at;
    double speed_deg_s = 0.0;
    for (const auto& value : values) {
        const std::string_view name = value.field->name;
        if (name == "speed") {
            speed_deg_s = physical(message, value);
            rests_ = std::abs(speed_deg_s) <= rest_deg_s;
            state.velocity_rad_s = {output_rad(speed_deg_s), at};
        } else if (name == "temperature") {
            state.temperature_c = {physical(message, value), at};
        } else if (name == "voltage") {
            state.voltage_v = {physical(message, value), at};
        } else if (name == "iq" && can_.measures_current) {
            state.current_a = {physical(message, value), at};
        } else if (name == "error_state") {
            absorb_faults(value.raw, at, state);
        } else if (name == "encoder") {
            if (const auto deg = track_.encoder(value.raw, speed_deg_s, at))
                state.position_rad = {output_rad(*deg), at};
        }
    }
}

std::expected<void, Error> Driver::absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                          actuator::State& state)
{
    const wire::MessageInfo& message = *asked.message;
    const bool is_group = message.request.layout->can_fixed;
    if (is_group && reply.can_id != spec_.reply_identifier())
        return {};
    const auto answer = wire::decode(message, wire::Direction::reply, reply, asked.options);
    if (!answer)
        return std::unexpected(answer.error());
    const wire::Values& values = answer->values;
    if (message.name() == "motor-running")
        off_ = said_off_ = false;
    if (message.name() == "brake-release" ||
        (message.name() == "brake-control" && values.find("brake") == brake_is_free))
        braked_ = false;
    if (const auto motor_state = values.find("motor_state"))
        absorb_switch(*motor_state != motor_is_on, at, state);
    if (message.name() == "read-multi-turn-angle" && !values.all().empty())
        absorb_angle(physical(message, values.all().front()), at, state);
    // Only what the motor measured: acknowledgements repeat what was asked.
    if (values.find("temperature"))
        absorb_motion(message, values, at, state);
    compare_settings(message, values);
    return {};
}

} // namespace sinew::rmd
