#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/sam/models.hpp"

namespace sinew::sam {

/// A SAM servo in SI. It speaks standard messages, which reach every id, and precise positions where the model has
/// them. Wheel speed is PWM duty: velocity is open loop, in proportion to the rated speed. Positive is the sense in
/// which raw positions grow; that this is clockwise is `Profile::clockwise_positive`, which no document states.
class Driver final : public actuator::Driver
{
public:
    explicit Driver(const Spec& spec);

    const actuator::Capabilities& capabilities() const override { return can_; }
    std::expected<wire::Requests, Error> plan(const actuator::Command& command, const actuator::State& state) override;
    std::expected<wire::Requests, Error> plan_read(actuator::Depth depth) override;
    std::expected<void, Error> absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                      actuator::State& state) override;

private:
    template <class M>
    std::expected<void, Error> add(wire::Requests& out, const M& message) const;
    std::expected<void, Error> go_to(wire::Requests& out, double position_rad) const;
    std::expected<void, Error> turn(wire::Requests& out, double velocity_rad_s) const;

    Spec spec_;
    actuator::Capabilities can_;
};

} // namespace sinew::sam
