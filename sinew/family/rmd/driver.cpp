#include "sinew/family/rmd/driver.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"
#include "sinew/family/rmd/lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace sinew::rmd {
namespace {

constexpr double angle_lsb_deg = 0.01; // A3 … A8 (L860, L901)
constexpr double speed_lsb_dps = 0.01; // A2 (L813)
/// lk-2.36 sends a current limit with the speed: full scale leaves it to the motor. Other lines have no such field.
constexpr std::int64_t no_current_limit = 2048;
constexpr std::int64_t fastest_limit = 65535;
constexpr std::int64_t full_power = 850; // L745
constexpr std::int64_t engage_brake = 0; // of brake-control, LK lines
constexpr std::int64_t free_brake = 1;
/// Rounding down must not take one unit more because of the noise of a conversion.
constexpr double noise = 1e-6;

/// The message and the field of a torque command, and the most that it can carry.
struct TorqueField {
    std::string_view field;
    double a_per_lsb = 0.0;
    std::int64_t most = 0;
};

TorqueField torque_field(const Spec& spec)
{
    if (spec.profile.dialect == Dialect::gyems)
        return {"iq_control", 0.016, 2000};
    if (spec.profile.iq_in_centiamperes)
        return {"iq", *spec.iq_a(), std::numeric_limits<std::int16_t>::max()};
    return {"iq", spec.iq_a().value_or(0.0), 2048};
}

} // namespace

Driver::Driver(const Spec& spec) : spec_(spec), track_(spec.profile.sent_encoder_bits())
{
    can_.position_high_rad = output_rad(static_cast<double>(std::numeric_limits<std::int32_t>::max()) * angle_lsb_deg);
    can_.position_low_rad = -*can_.position_high_rad;
    can_.position_step_rad = output_rad(angle_lsb_deg);
    can_.velocity = can_.velocity_limit = can_.timed = actuator::able;
    can_.timing = actuator::Timing::by_speed;
    can_.timed_velocity.why_not = "the motor changes its speed as fast as its acceleration setting lets it";
    can_.measures_velocity = can_.measures_voltage = can_.measures_temperature = can_.measures_faults = true;
    can_.measures_enabled = spec_.profile.dialect == Dialect::lk || spec_.profile.dialect == Dialect::lk_2_36;
    can_.measures_current = can_.current_has_sign = spec_.iq_a().has_value();
    find_abilities();
}

void Driver::find_abilities()
{
    const bool has_brake = has("brake-control") || has("brake-lock");
    can_.brake = has_brake ? actuator::able : actuator::Ability{"this firmware line has no brake; hold or release"};
    const bool limits_current = has("speed-closed-loop-torque") || spec_.profile.dialect == Dialect::lk_2_36;
    if (spec_.model->iq == Iq::power) {
        can_.current.why_not = can_.current_limit.why_not = can_.torque.why_not =
            "motors of class MS take a share of the power (mode duty), not a current";
        can_.duty =
            has("torque-open-loop") ? actuator::able : actuator::Ability{"this firmware line has no torque-open-loop"};
        return;
    }
    can_.duty.why_not = "only motors of class MS take a share of the power; use mode current";
    if (!spec_.iq_a()) {
        can_.current.why_not = can_.current_limit.why_not = can_.torque.why_not =
            "amperes need a class of motor; name it (model = \"MG\", \"MF\" …) or torque_current_full_scale_a";
        return;
    }
    can_.current = actuator::able;
    const TorqueField field = torque_field(spec_);
    can_.current_max_a = static_cast<double>(field.most) * field.a_per_lsb;
    can_.current_limit = limits_current
                             ? actuator::able
                             : actuator::Ability{"this firmware line has no speed command with a limit of the current"};
    can_.torque_constant_nm_per_a = spec_.profile.torque_constant_nm_per_a;
    can_.torque = can_.torque_constant_nm_per_a
                      ? actuator::able
                      : actuator::Ability{"the torque constant is not known; give torque_constant_nm_per_a of the "
                                          "motor's data sheet, or use mode current"};
}

std::expected<void, Error> Driver::add(wire::Requests& out, std::string_view message,
                                       std::initializer_list<wire::NamedNumber> numbers) const
{
    auto request =
        wire::make_request(spec_.profile.line, message, spec_.id, numbers, spec_.profile.options(), response_time);
    if (!request)
        return std::unexpected(std::move(request.error()));
    out.add(*request);
    return {};
}

// ---- the shaft that is counted, and the output ----

std::int64_t Driver::to_raw(double rad, double lsb_deg) const
{
    return std::llround(units::deg(rad) * spec_.profile.gear_ratio / lsb_deg);
}

double Driver::output_rad(double deg) const
{
    return units::rad(deg) / spec_.profile.gear_ratio;
}

// ---- commands ----

std::expected<void, Error> Driver::add_run(wire::Requests& out) const
{
    // Lines without this message start by any motion command.
    if (off_ && has("motor-running"))
        if (auto on = add(out, "motor-running"); !on)
            return on;
    if (!braked_)
        return {};
    return has("brake-control") ? add(out, "brake-control", {{"brake", free_brake}}) : add(out, "brake-release");
}

/// The limit of a move in the units of the firmware line.
std::expected<std::int64_t, Error> Driver::speed_limit_raw(const actuator::Command& command,
                                                           const actuator::State& state) const
{
    const double lsb = spec_.profile.sent_max_speed_lsb_dps();
    if (command.duration && !state.position_rad)
        return actuator::refuse(Errc::unsupported, spec_.id,
                                "a move with a duration begins at the measured position; read its state first");
    double raw = 0.0;
    if (command.duration) {
        const double way = std::abs(*command.position_rad - *state.position_rad);
        raw = std::max(1.0, std::round(units::deg(way) * spec_.profile.gear_ratio / seconds(*command.duration) / lsb));
    } else {
        // A limit is never exceeded.
        raw = std::floor(units::deg(*command.velocity_rad_s) * spec_.profile.gear_ratio / lsb + noise);
    }
    if (raw < 1.0 || raw > static_cast<double>(fastest_limit))
        return actuator::refuse(Errc::out_of_range, spec_.id,
                                fmt::format("the speed of a move goes from {:g} to {:g} deg/s on this firmware line",
                                            lsb / spec_.profile.gear_ratio,
                                            lsb * static_cast<double>(fastest_limit) / spec_.profile.gear_ratio));
    return static_cast<std::int64_t>(raw);
}

std::expected<void, Error> Driver::go_to(wire::Requests& out, const actuator::Command& command,
                                         const actuator::State& state) const
{
    const std::int64_t angle = to_raw(*command.position_rad, angle_lsb_deg);
    if (!command.velocity_rad_s && !command.duration) {
        if (!has("multi-loop-angle"))
            return actuator::refuse(Errc::unsupported, spec_.id,
                                    "this firmware line moves to an angle at a named speed only; name one");
        if (auto on = add_run(out); !on)
            return on;
        return add(out, "multi-loop-angle", {{"angle", angle}});
    }
    const auto max_speed = speed_limit_raw(command, state);
    if (!max_speed)
        return std::unexpected(max_speed.error());
    if (auto on = add_run(out); !on)
        return on;
    return add(out, "multi-loop-angle-speed", {{"max_speed", *max_speed}, {"angle", angle}});
}

std::expected<std::int64_t, Error> Driver::current_raw(double current_a, double a_per_lsb, std::int64_t most) const
{
    const double raw = std::trunc(current_a / a_per_lsb + std::copysign(noise, current_a));
    if (std::abs(raw) > static_cast<double>(most))
        return actuator::refuse(Errc::out_of_range, spec_.id,
                                fmt::format("{:g} A is more than the {:g} A that a command can carry", current_a,
                                            static_cast<double>(most) * a_per_lsb));
    return static_cast<std::int64_t>(raw);
}

std::expected<void, Error> Driver::turn(wire::Requests& out, double velocity_rad_s,
                                        std::optional<double> current_a) const
{
    std::int64_t limit = no_current_limit;
    if (current_a) {
        const auto raw = current_raw(*current_a, *spec_.iq_a(), no_current_limit);
        if (!raw)
            return std::unexpected(raw.error());
        limit = *raw;
    }
    const double counted = std::round(units::deg(velocity_rad_s) * spec_.profile.gear_ratio / speed_lsb_dps);
    if (std::abs(counted) > static_cast<double>(std::numeric_limits<std::int32_t>::max()))
        return actuator::refuse(
            Errc::out_of_range, spec_.id,
            fmt::format("{:g} deg/s is more than a speed command can carry", units::deg(velocity_rad_s)));
    if (auto on = add_run(out); !on)
        return on;
    const bool with_limit = current_a && has("speed-closed-loop-torque");
    return add(out, with_limit ? "speed-closed-loop-torque" : "speed-closed-loop",
               {{"speed", static_cast<std::int64_t>(counted)}, {"iq", limit}});
}

std::expected<double, Error> Driver::current_of(const actuator::Command& command) const
{
    if (auto fine = actuator::check(command, can_, spec_.id); !fine)
        return std::unexpected(std::move(fine.error()));
    if (command.mode == actuator::Mode::current)
        return *command.current_a;
    if (command.mode == actuator::Mode::torque)
        return *command.torque_nm / *can_.torque_constant_nm_per_a;
    return actuator::refuse(Errc::bad_argument, spec_.id,
                            fmt::format("mode {} asks for no current", to_word(command.mode)));
}

std::expected<void, Error> Driver::push(wire::Requests& out, double current_a) const
{
    const TorqueField field = torque_field(spec_);
    const auto raw = current_raw(current_a, field.a_per_lsb, field.most);
    if (!raw)
        return std::unexpected(raw.error());
    if (auto on = add_run(out); !on)
        return on;
    return add(out, "torque-closed-loop", {{field.field, *raw}});
}

/// An LK motor that is switched off loses the turns that it has counted (field notes 1): its angle is to be read anew,
/// and is no sign of a reset.
void Driver::forget_turns()
{
    if (!spec_.profile.off_requires_run)
        return;
    track_.forget();
    angle_deg_.reset();
    has_lost_turns_ = true;
}

std::expected<wire::Requests, Error> Driver::plan_idle()
{
    const bool is_power = spec_.model->iq == Iq::power;
    if (is_power && !has("torque-open-loop"))
        return actuator::refuse(Errc::unsupported, spec_.id, "this firmware line has no torque-open-loop");
    target_deg_.reset();
    wire::Requests out;
    auto added = add_run(out);
    if (added)
        added = is_power ? add(out, "torque-open-loop", {{"power", 0}})
                         : add(out, "torque-closed-loop", {{torque_field(spec_).field, 0}});
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

std::expected<void, Error> Driver::brake(wire::Requests& out)
{
    auto added = has("brake-control") ? add(out, "brake-control", {{"brake", engage_brake}}) : add(out, "brake-lock");
    // The drive must not work against it.
    if (added)
        added = add(out, "motor-off");
    off_ = braked_ = true;
    forget_turns();
    return added;
}

std::expected<void, Error> Driver::carry_out(wire::Requests& out, const actuator::Command& command,
                                             const actuator::State& state)
{
    target_deg_.reset();
    switch (command.mode) {
    case actuator::Mode::hold:
        // Speed 0 holds with torque on every line, whatever the motor was doing, and needs no position that may be old.
        return turn(out, 0.0, {});
    case actuator::Mode::release: {
        auto added = add(out, "motor-off");
        if (added && can_.measures_enabled)
            added = add(out, "motor-off");
        off_ = true;
        forget_turns();
        return added;
    }
    case actuator::Mode::brake:
        return brake(out);
    case actuator::Mode::position:
        target_deg_ = units::deg(*command.position_rad) * spec_.profile.gear_ratio;
        return go_to(out, command, state);
    case actuator::Mode::velocity:
        return turn(out, *command.velocity_rad_s, command.current_a);
    case actuator::Mode::current:
    case actuator::Mode::torque: {
        const auto current = current_of(command);
        return current ? push(out, *current) : std::unexpected(current.error());
    }
    case actuator::Mode::duty: {
        if (auto on = add_run(out); !on)
            return on;
        const auto power = static_cast<std::int64_t>(std::trunc(*command.duty * static_cast<double>(full_power)));
        return add(out, "torque-open-loop", {{"power", power}});
    }
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

} // namespace sinew::rmd
