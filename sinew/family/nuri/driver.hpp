#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/nuri/models.hpp"
#include "sinew/wire/by_name.hpp"

#include <array>

namespace sinew::nuri {

/// A Nuri actuator in SI. Commands are never answered, so what they did shows in the next state.
///
/// Sign and magnitude travel apart: position feedback has the sign of the position and the bare magnitude of the speed,
/// speed feedback the other way round. A value is told only with a sign that was measured with it:
///
/// - The velocity comes from speed feedback, with depth full. Position feedback alone tells a velocity only at 0.
/// - The position comes from position feedback, which ends (or starts again, `Profile::position_feedback_limit`) at
///   655.33° (N17). Beyond, its sign and the magnitude of speed feedback make the position, where both are so close in
///   time that the shaft cannot have come through zero between them; such a state takes both requests at any depth.
///   Where feedback starts again, that of speed does so, too, at 6553.3°: the rounds are counted from look to look. A
///   device that was beyond that end before it was first looked at is told short of it by as many rounds.
/// - The current has no sign.
///
/// Positions and speeds are those behind the external gear whose ratio the device knows (N33), so none is applied here.
/// A move without a velocity goes at 5 rpm, as in the manual's example: mode 1 has no "as fast as it can". A duration
/// is rounded up to 0.1 s.
///
/// No setting of a Nuri is for the run-time only (N14), so `plan_settings` has nothing to send. A reset shows in
/// settings that are not what they were, and in a device that is on although it was off; the loss of its zero does not
/// show at all.
class Driver final : public actuator::Driver
{
public:
    explicit Driver(const Spec& spec);

    const actuator::Capabilities& capabilities() const override { return can_; }
    std::expected<wire::Requests, Error> plan(const actuator::Command& command, const actuator::State& state) override;
    std::expected<wire::Requests, Error> plan_read(actuator::Depth depth, double resolution_rad = 0.0) override;
    std::expected<wire::Requests, Error> plan_cycle(const actuator::Command& command,
                                                    const actuator::State& state) override;
    std::expected<void, Error> absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                      actuator::State& state) override;
    std::expected<wire::Requests, Error> plan_settings() override;
    std::expected<wire::Requests, Error> plan_reset_check() override;
    std::string_view noticed_reset() const override { return reset_; }

private:
    std::expected<void, Error> add(wire::Requests& out, std::string_view message,
                                   std::initializer_list<wire::NamedNumber> numbers = {}) const;
    std::expected<void, Error> add_all(wire::Requests& out, std::initializer_list<std::string_view> messages) const;
    std::expected<void, Error> switch_on(wire::Requests& out);
    std::expected<void, Error> go_to(wire::Requests& out, const actuator::Command& command);
    std::expected<void, Error> turn(wire::Requests& out, double velocity_rad_s, std::int64_t arrival_time);
    std::expected<void, Error> carry_out(wire::Requests& out, const actuator::Command& command);
    std::expected<void, Error> read_position(wire::Requests& out) const;
    std::int64_t direction(double value) const;
    double signed_by(std::int64_t direction, double magnitude) const;
    void absorb_position(const wire::Values& values, TimePoint at, actuator::State& state);
    void absorb_speed(const wire::Values& values, TimePoint at, actuator::State& state);
    std::optional<double> far_position(double far_rad, double speed_rad_s, TimePoint at);
    double with_rounds(double position_rad, double speed_rad_s, TimePoint at);
    void absorb_switch(bool off, TimePoint at, actuator::State& state);
    void compare_settings(std::string_view message, const wire::Frame& reply);

    /// What position feedback said where it does not say all.
    struct Heard {
        double sign = 1.0;
        double fine_rad = 0.0;
        double speed_rad_s = 0.0;
        TimePoint at{};
    };

    /// Where it was when it was last looked at beyond what one look can tell.
    struct Followed {
        double position_rad = 0.0;
        double speed_rad_s = 0.0;
        TimePoint at{};
    };

    Spec spec_;
    actuator::Capabilities can_;
    bool off_ = false;                 ///< switched off by us, or said so by itself
    bool said_off_ = false;            ///< said so by itself, and not switched on since
    std::optional<bool> relative_;     ///< as it said itself; a position is planned only where it is known
    std::optional<Heard> far_;         ///< speed feedback must say how far
    std::optional<Followed> followed_; ///< of a device whose feedback starts again
    std::array<std::optional<wire::Frame>, 3> settings_{}; ///< as they were when first heard
    std::string_view reset_;
};

} // namespace sinew::nuri
