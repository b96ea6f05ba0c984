#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/rmd/encoder_track.hpp"
#include "sinew/family/rmd/models.hpp"
#include "sinew/wire/by_name.hpp"

#include <utility>

namespace sinew::rmd {

/// An RMD motor in SI, at its output: `Profile::gear_ratio` lies between that and the shaft whose angle it counts.
/// Positive is clockwise, as the manual counts (L469). Where nobody named the profile, speed limits go out in the scale
/// that can only make the motor slower (R01).
///
/// - The answer to a motion command is a state: speed, current and temperature, and by its encoder the position as well
///   once that has proven itself (`EncoderTrack`), so that a control loop takes one exchange a motor.
/// - A duration is sent as the speed limit that covers the way from the measured position in that time, to the nearest
///   unit of the firmware line; ramps come on top.
/// - Currents need a class of motor (or `torque_current_full_scale_a`), torques `torque_constant_nm_per_a` as well.
///   They are rounded towards zero. The motor does not limit them (L791).
/// - Brake engages the holding brake of the lines that have one, and takes the torque off.
/// - LK lines are told twice to go off, for they may take a command one frame late (field notes 2).
/// - Run-time settings: the acceleration, and the gains where the line has a message for them. A reset shows in
/// settings
///   that are gone, in turns that are lost, and in an LK motor that is on although it said that it was off.
class Driver final : public actuator::Driver
{
public:
    explicit Driver(const Spec& spec);

    const actuator::Capabilities& capabilities() const override { return can_; }
    std::expected<wire::Requests, Error> plan(const actuator::Command& command, const actuator::State& state) override;
    std::expected<wire::Requests, Error> plan_idle() override;
    std::expected<wire::Requests, Error> plan_read(actuator::Depth depth, double resolution_rad = 0.0) override;
    std::expected<wire::Requests, Error> plan_cycle(const actuator::Command& command,
                                                    const actuator::State& state) override;
    /// Of the answers to a torque group it takes the one of its own motor and leaves the others alone.
    std::expected<void, Error> absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                      actuator::State& state) override;
    std::expected<wire::Requests, Error> plan_settings() override;
    std::expected<wire::Requests, Error> plan_reset_check() override;
    std::string_view noticed_reset() const override { return reset_; }
    bool take_lost_count() override { return std::exchange(has_lost_turns_, false); }

    const Spec& spec() const { return spec_; }
    /// The current that a command of mode current or torque asks for.
    std::expected<double, Error> current_of(const actuator::Command& command) const;
    /// What must go out before the motor obeys a motion command; nothing if it is running.
    std::expected<void, Error> add_run(wire::Requests& out) const;

private:
    std::expected<void, Error> add(wire::Requests& out, std::string_view message,
                                   std::initializer_list<wire::NamedNumber> numbers = {}) const;
    bool has(std::string_view message) const { return spec_.profile.line.find(message) != nullptr; }
    void find_abilities();
    std::expected<void, Error> go_to(wire::Requests& out, const actuator::Command& command,
                                     const actuator::State& state) const;
    std::expected<std::int64_t, Error> speed_limit_raw(const actuator::Command& command,
                                                       const actuator::State& state) const;
    std::expected<void, Error> turn(wire::Requests& out, double velocity_rad_s, std::optional<double> current_a) const;
    std::expected<void, Error> push(wire::Requests& out, double current_a) const;
    void forget_turns();
    std::expected<void, Error> brake(wire::Requests& out);
    std::expected<void, Error> carry_out(wire::Requests& out, const actuator::Command& command,
                                         const actuator::State& state);
    std::expected<std::int64_t, Error> current_raw(double current_a, double a_per_lsb, std::int64_t most) const;
    std::int64_t to_raw(double rad, double lsb_deg) const;
    double output_rad(double deg) const;

    double physical(const wire::MessageInfo& message, const wire::Value& value) const;
    void absorb_motion(const wire::MessageInfo& message, const wire::Values& values, TimePoint at,
                       actuator::State& state);
    void absorb_angle(double deg, TimePoint at, actuator::State& state);
    void absorb_faults(std::int64_t raw, TimePoint at, actuator::State& state) const;
    void absorb_switch(bool off, TimePoint at, actuator::State& state);
    void compare_settings(const wire::MessageInfo& message, const wire::Values& values);
    void look_for_lost_turns(double deg);
    void notice(std::string_view what);
    void notice_lost_turns();

    Spec spec_;
    actuator::Capabilities can_;
    EncoderTrack track_;
    int cycles_ = 0;                   ///< since the angle was asked for
    std::optional<double> angle_deg_;  ///< that was read last
    std::optional<double> target_deg_; ///< of the last command, where it had one
    bool rests_ = false;               ///< by the speed that was read last
    bool rested_ = false;              ///< when the angle was read last
    /// Switched off by us, or said so by itself; motor-running must be answered before the next motion (R30).
    bool off_ = false;
    bool said_off_ = false; ///< said so by itself, and not run since
    bool braked_ = false;   ///< by us
    bool set_ = false;      ///< run-time settings were planned
    std::string_view reset_;
    bool has_lost_turns_ = false; ///< and nobody has asked since
};

} // namespace sinew::rmd
