#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/sam/models.hpp"

namespace sinew::sam {

/// A SAM servo in SI. Positive is the sense in which raw positions grow; that this is clockwise is
/// `Profile::clockwise_positive`, which no document states.
///
/// - Positions go in the finest coordinates of the model; where a command names a coarser resolution, in the shortest
///   message that is fine enough: quick (1.08°, ids 0 … 30, with the strongest of its torque levels), standard,
///   precise. Each kind has boundaries of its own in the device (S61).
/// - At response level 1 the answer to a position command is a state: that of the moment before the motion (L736).
/// - Wheel speed is PWM duty, clockwise up to 99.9 % (S41). Mode velocity is that, in proportion to the rated speed.
/// - Hold goes to the position that was measured last, or to the nearest that may be commanded.
/// - No message moves at a speed or in a time, or drives with a current: the units of the CTRL registers are in no
///   document (S36).
/// - Run-time settings: the P, D and I gains. That they are gone is the only sign of a reset.
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
    template <class M>
    std::expected<void, Error> add(wire::Requests& out, const M& message) const;
    const PositionScale& finest() const;
    bool can_be(const PositionScale& scale, double resolution_rad) const;
    const PositionScale& scale_for(double position_rad, double resolution_rad) const;
    std::expected<void, Error> go_to(wire::Requests& out, double position_rad, double resolution_rad) const;
    std::expected<void, Error> read_position(wire::Requests& out, double resolution_rad) const;
    std::expected<void, Error> wheel(wire::Requests& out, double duty) const;
    std::expected<void, Error> carry_out(wire::Requests& out, const actuator::Command& command,
                                         const actuator::State& state) const;
    bool absorb_motion(const wire::Request& asked, const wire::Frame& reply, TimePoint at, actuator::State& state,
                       std::expected<void, Error>& result) const;
    bool absorb_gains(const wire::Request& asked, const wire::Frame& reply, std::expected<void, Error>& result);

    Spec spec_;
    actuator::Capabilities can_;
    bool set_ = false; ///< run-time settings were planned
    std::string_view reset_;
};

} // namespace sinew::sam
