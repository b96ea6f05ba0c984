#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/rmd/models.hpp"
#include "sinew/wire/by_name.hpp"

namespace sinew::rmd {

/// An RMD motor in SI, at the shaft that its encoder measures. Positive is clockwise, as the manual counts (L469).
/// Where nobody named the profile, speed limits go out in the scale that can only make the motor slower (R01).
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
    std::expected<void, Error> add(wire::Requests& out, std::string_view message,
                                   std::initializer_list<wire::NamedNumber> numbers = {}) const;
    std::expected<void, Error> run(wire::Requests& out);
    std::expected<void, Error> go_to(wire::Requests& out, double position_rad, std::optional<double> limit_rad_s);
    std::expected<void, Error> turn(wire::Requests& out, double velocity_rad_s);
    double physical(const wire::MessageInfo& message, const wire::Value& value) const;
    void absorb_faults(std::int64_t raw, actuator::State& state) const;

    Spec spec_;
    actuator::Capabilities can_;
    /// Switched off by us, or said so by itself; motor-running must be answered before the next motion (R30).
    bool off_ = false;
};

} // namespace sinew::rmd
