#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/nuri/models.hpp"
#include "sinew/wire/by_name.hpp"

namespace sinew::nuri {

/// A Nuri actuator in SI. Commands are never answered, so what they did shows in the next state. Sign and magnitude
/// travel apart: position feedback tells the sign of the position only and speed feedback that of the speed only, so a
/// signed velocity comes with depth full.
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
    std::expected<void, Error> switch_on(wire::Requests& out);
    std::expected<void, Error> go_to(wire::Requests& out, double position_rad, double speed_rad_s);
    std::expected<void, Error> turn(wire::Requests& out, double velocity_rad_s, std::int64_t arrival_time);
    std::int64_t direction(double value) const;
    double signed_by(std::int64_t direction, double magnitude) const;

    Spec spec_;
    actuator::Capabilities can_;
    bool off_ = false;             ///< switched off by us, or said so by itself
    std::optional<bool> relative_; ///< as it said itself; a position is planned only where it is known
};

} // namespace sinew::nuri
