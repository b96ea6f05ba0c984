#include "sinew/family/nuri/driver.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/seconds.hpp"
#include "sinew/base/units.hpp"
#include "sinew/family/nuri/messages.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::nuri {
namespace {

constexpr double position_lsb_deg = 0.01;    // items 1, 2, 16
constexpr double far_position_lsb_deg = 0.1; // item 17 (N06)
constexpr double speed_lsb_rpm = 0.1;
constexpr double current_lsb_a = 0.1;
constexpr double time_lsb_s = 0.1;
constexpr std::int64_t largest = 65533; // N04
constexpr std::int64_t longest = 255;   // items 2, 3
/// The speed of the manual's own example (L8), where a caller names none: mode 1 has no "as fast as possible".
constexpr double default_speed_rad_s = units::rad_s_from_rpm(5.0);
/// Arrival time of a speed, in 0.1 s: that of the manual's example (L22).
constexpr std::int64_t speed_arrival_time = 10;
constexpr std::int64_t shortest_arrival_time = 1;
/// Two kinds of feedback further apart than this say nothing about each other.
constexpr Duration together = std::chrono::milliseconds{500};
/// A shaft may have been so much faster between two looks than at either.
constexpr double faster_between = 2.0;

constexpr std::string_view no_current = "the protocol has no command for a current, only stored ratings";
constexpr std::array<std::string_view, 3> watched_settings = {
    "request-position-controller-feedback", "request-speed-controller-feedback", "request-gear-ratio-feedback"};

/// Rounded down, but for the noise of the conversion: nothing turns faster than asked.
std::expected<std::int64_t, Error> speed_raw(double speed_rad_s, std::int64_t least, int id)
{
    const double raw = std::floor(units::rpm(std::abs(speed_rad_s)) / speed_lsb_rpm + 1e-6);
    if (raw < static_cast<double>(least) || raw > static_cast<double>(largest))
        return actuator::refuse(
            Errc::out_of_range, id,
            fmt::format("a speed goes from {:g} to {:g} deg/s", units::deg(units::rad_s_from_rpm(speed_lsb_rpm)),
                        units::deg(units::rad_s_from_rpm(static_cast<double>(largest) * speed_lsb_rpm))));
    return static_cast<std::int64_t>(raw);
}

/// Rounded up likewise.
std::int64_t time_raw(Duration time)
{
    return std::max(shortest_arrival_time, static_cast<std::int64_t>(std::ceil(seconds(time) / time_lsb_s - 1e-6)));
}

/// Between two looks, whatever it did there.
double turned_at_most(double before_rad_s, double after_rad_s, Duration between)
{
    return faster_between * std::max(before_rad_s, after_rad_s) * std::abs(seconds(between));
}

double number(const wire::Values& values, std::string_view name)
{
    return static_cast<double>(values.find(name).value_or(0));
}

} // namespace

Driver::Driver(const Spec& spec) : spec_(spec)
{
    const double end = units::rad(static_cast<double>(largest) * position_lsb_deg);
    can_.position_low_rad = -end;
    can_.position_high_rad = end;
    can_.position_step_rad = units::rad(position_lsb_deg);
    can_.velocity = can_.velocity_limit = can_.timed = can_.timed_velocity = actuator::able;
    can_.timing = actuator::Timing::by_device;
    can_.duration_max = from_seconds(static_cast<double>(longest) * time_lsb_s);
    can_.current.why_not = can_.current_limit.why_not = can_.torque.why_not = can_.duty.why_not = no_current;
    can_.brake.why_not = "the protocol has no brake; release takes the torque off";
    can_.measures_velocity = can_.measures_current = can_.measures_enabled = true;
}

std::int64_t Driver::direction(double value) const
{
    const bool counter_clockwise = (value >= 0.0) == spec_.profile.ccw_positive;
    return static_cast<std::int64_t>(counter_clockwise ? Rotation::counter_clockwise : Rotation::clockwise);
}

double Driver::signed_by(std::int64_t direction, double magnitude) const
{
    const bool counter_clockwise = direction == static_cast<std::int64_t>(Rotation::counter_clockwise);
    return counter_clockwise == spec_.profile.ccw_positive ? magnitude : -magnitude;
}

std::expected<void, Error> Driver::add(wire::Requests& out, std::string_view message,
                                       std::initializer_list<wire::NamedNumber> numbers) const
{
    auto request = wire::make_request(spec_.profile.line, message, spec_.id, numbers, spec_.profile.options(),
                                      spec_.profile.response_time());
    if (!request)
        return std::unexpected(std::move(request.error()));
    out.add(*request);
    return {};
}

std::expected<void, Error> Driver::add_all(wire::Requests& out, std::initializer_list<std::string_view> messages) const
{
    for (const auto message : messages)
        if (auto added = add(out, message); !added)
            return added;
    return {};
}

// ---- commands ----

std::expected<void, Error> Driver::switch_on(wire::Requests& out)
{
    if (!off_)
        return {};
    off_ = said_off_ = false;
    return add(out, "set-control-on-off", {{"control", static_cast<std::int64_t>(Control::on)}});
}

std::expected<void, Error> Driver::go_to(wire::Requests& out, const actuator::Command& command)
{
    // What is an absolute angle here would be a turn from where the shaft is (L77).
    if (!relative_)
        return actuator::refuse(Errc::unsupported, spec_.id,
                                "whether positions are absolute is not known yet; read its state first");
    if (*relative_)
        return actuator::refuse(Errc::unsupported, spec_.id,
                                "the device is set to relative positions; set position_mode=absolute first");
    const std::int64_t sense = direction(*command.position_rad);
    const std::int64_t position = std::llround(std::abs(units::deg(*command.position_rad)) / position_lsb_deg);
    if (command.duration) {
        if (auto on = switch_on(out); !on)
            return on;
        return add(
            out, "accel-position-control",
            {{"position_direction", sense}, {"position", position}, {"arrival_time", time_raw(*command.duration)}});
    }
    const auto speed = speed_raw(command.velocity_rad_s.value_or(default_speed_rad_s), 1, spec_.id);
    if (!speed)
        return std::unexpected(speed.error());
    if (auto on = switch_on(out); !on)
        return on;
    return add(out, "position-speed-control",
               {{"position_direction", sense}, {"position", position}, {"speed", *speed}});
}

std::expected<void, Error> Driver::turn(wire::Requests& out, double velocity_rad_s, std::int64_t arrival_time)
{
    const auto speed = speed_raw(velocity_rad_s, velocity_rad_s == 0.0 ? 0 : 1, spec_.id);
    if (!speed)
        return std::unexpected(speed.error());
    if (auto on = switch_on(out); !on)
        return on;
    return add(out, "accel-speed-control",
               {{"speed_direction", direction(velocity_rad_s)}, {"speed", *speed}, {"arrival_time", arrival_time}});
}

std::expected<void, Error> Driver::carry_out(wire::Requests& out, const actuator::Command& command)
{
    switch (command.mode) {
    case actuator::Mode::hold:
        // Not by position: feedback ends at 655.33 deg (N17), and in relative mode it would be a turn.
        return turn(out, 0.0, shortest_arrival_time);
    case actuator::Mode::release:
        off_ = true;
        return add(out, "set-control-on-off", {{"control", static_cast<std::int64_t>(Control::off)}});
    case actuator::Mode::position:
        return go_to(out, command);
    case actuator::Mode::velocity:
        return turn(out, *command.velocity_rad_s, command.duration ? time_raw(*command.duration) : speed_arrival_time);
    case actuator::Mode::brake:
    case actuator::Mode::current:
    case actuator::Mode::torque:
    case actuator::Mode::duty:
        break; // refused by `check`
    }
    return {};
}

std::expected<wire::Requests, Error> Driver::plan(const actuator::Command& command, const actuator::State&)
{
    if (auto fine = actuator::check(command, can_, spec_.id); !fine)
        return std::unexpected(std::move(fine.error()));
    wire::Requests out;
    if (auto added = carry_out(out, command); !added)
        return std::unexpected(std::move(added.error()));
    return out;
}

// ---- reading ----

std::expected<void, Error> Driver::read_position(wire::Requests& out) const
{
    auto added = add(out, "request-position-feedback");
    const bool ambiguous = far_ || spec_.profile.position_feedback_limit == PositionFeedbackLimit::wrap;
    if (added && ambiguous)
        added = add(out, "request-speed-feedback");
    // Once in any case: a position means something else in relative mode.
    if (added && !relative_)
        added = add(out, "request-position-mode-feedback");
    return added;
}

std::expected<wire::Requests, Error> Driver::plan_read(actuator::Depth depth, double)
{
    wire::Requests out;
    auto added = depth == actuator::Depth::motion
                     ? read_position(out)
                     : add_all(out, {"request-position-feedback", "request-speed-feedback",
                                     "request-control-on-off-feedback", "request-position-mode-feedback"});
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

std::expected<wire::Requests, Error> Driver::plan_cycle(const actuator::Command& command, const actuator::State& state)
{
    auto out = plan(command, state);
    if (!out)
        return out;
    if (auto added = read_position(*out); !added)
        return std::unexpected(std::move(added.error()));
    return out;
}

void Driver::absorb_position(const wire::Values& values, TimePoint at, actuator::State& state)
{
    const double sign = signed_by(*values.find("position_direction"), 1.0);
    const double magnitude = units::rad(number(values, "position") * position_lsb_deg);
    const double speed = units::rad_s_from_rpm(number(values, "speed") * speed_lsb_rpm);
    const bool wraps = spec_.profile.position_feedback_limit == PositionFeedbackLimit::wrap;
    if (wraps || values.find("position") == largest) {
        far_ = Heard{.sign = sign, .fine_rad = magnitude, .speed_rad_s = speed, .at = at};
    } else {
        far_.reset();
        state.position_rad = {sign * magnitude, at};
    }
    // No sign of the speed travels here: only standing still is certain.
    if (speed == 0.0)
        state.velocity_rad_s = {0.0, at};
}

double Driver::with_rounds(double position_rad, double speed_rad_s, TimePoint at)
{
    const double span = units::rad(static_cast<double>(largest + 1) * far_position_lsb_deg);
    if (followed_ && turned_at_most(followed_->speed_rad_s, speed_rad_s, at - followed_->at) < span / 4.0)
        position_rad += span * std::round((followed_->position_rad - position_rad) / span);
    followed_ = {.position_rad = position_rad, .speed_rad_s = speed_rad_s, .at = at};
    return position_rad;
}

std::optional<double> Driver::far_position(double far_rad, double speed_rad_s, TimePoint at)
{
    const double turned = turned_at_most(far_->speed_rad_s, speed_rad_s, at - far_->at);
    if (std::chrono::abs(at - far_->at) > together)
        return {};
    if (spec_.profile.position_feedback_limit == PositionFeedbackLimit::clamp) {
        const bool is_far = far_rad >= *can_.position_high_rad - units::rad(far_position_lsb_deg);
        return is_far && far_rad > turned ? std::optional(far_->sign * far_rad) : std::nullopt;
    }
    const double span = units::rad(static_cast<double>(largest + 1) * position_lsb_deg);
    if (turned > span / 4.0)
        return {};
    const double magnitude = far_->fine_rad + span * std::round((far_rad - far_->fine_rad) / span);
    return with_rounds(far_->sign * magnitude, speed_rad_s, at);
}

void Driver::absorb_speed(const wire::Values& values, TimePoint at, actuator::State& state)
{
    const double speed = units::rad_s_from_rpm(number(values, "speed") * speed_lsb_rpm);
    state.velocity_rad_s = {signed_by(*values.find("speed_direction"), speed), at};
    const bool wraps = spec_.profile.position_feedback_limit == PositionFeedbackLimit::wrap;
    if (!far_ || (!wraps && values.find("position") == largest))
        return;
    const double far_rad = units::rad(number(values, "position") * far_position_lsb_deg);
    if (const auto position = far_position(far_rad, speed, at))
        state.position_rad = {*position, at};
}

void Driver::absorb_switch(bool off, TimePoint at, actuator::State& state)
{
    // A device comes up switched on (L70).
    if (!off && said_off_)
        reset_ = "it is on although it was switched off";
    off_ = said_off_ = off;
    state.enabled = {!off, at};
}

void Driver::compare_settings(std::string_view message, const wire::Frame& reply)
{
    const auto* known = std::ranges::find(watched_settings, message);
    if (known == watched_settings.end())
        return;
    auto& before = settings_[static_cast<std::size_t>(known - watched_settings.begin())];
    if (before && *before != reply)
        reset_ = "its settings are not what they were";
    if (!before)
        before = reply;
}

std::expected<void, Error> Driver::absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                          actuator::State& state)
{
    if (!asked.message->reply.exists())
        return {};
    const auto answer = wire::decode(*asked.message, wire::Direction::reply, reply, asked.options);
    if (!answer)
        return std::unexpected(answer.error());
    const auto value = [&](std::string_view name) { return answer->values.find(name); };
    compare_settings(asked.message->name(), reply);
    if (value("position_direction"))
        absorb_position(answer->values, at, state);
    if (value("speed_direction"))
        absorb_speed(answer->values, at, state);
    if (const auto current = value("current"))
        state.current_a = {static_cast<double>(*current) * current_lsb_a, at};
    const auto switched = value("control");
    if (switched)
        absorb_switch(*switched == static_cast<std::int64_t>(Control::off), at, state);
    if (const auto mode = value("position_mode"))
        relative_ = *mode == static_cast<std::int64_t>(PositionMode::relative);
    if (value("current") || switched)
        state.at = at;
    return {};
}

// ---- resets ----

std::expected<wire::Requests, Error> Driver::plan_settings()
{
    settings_ = {};
    reset_ = {};
    followed_.reset();
    return wire::Requests{};
}

std::expected<wire::Requests, Error> Driver::plan_reset_check()
{
    wire::Requests out;
    auto added = add_all(out, {"request-control-on-off-feedback", "request-position-mode-feedback", watched_settings[0],
                               watched_settings[1], watched_settings[2]});
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

} // namespace sinew::nuri
