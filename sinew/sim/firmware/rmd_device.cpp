#include "sinew/sim/firmware/rmd_device.hpp"

#include "sinew/base/units.hpp"
#include "sinew/family/families.hpp"
#include "sinew/family/rmd/framing.hpp"

#include <array>
#include <string_view>

namespace sinew::sim {
namespace {

constexpr auto manual_services = services<RmdDevice>(rmd::ManualMessages{});
constexpr auto lk_2_35_services = services<RmdDevice>(rmd::Lk235Messages{});
constexpr auto lk_2_36_services = services<RmdDevice>(rmd::Lk236Messages{});
constexpr auto gyems_services = services<RmdDevice>(rmd::Gyems162Messages{});
constexpr auto myactuator_services = services<RmdDevice>(rmd::MyActuator3Messages{});

constexpr int full_scale_raw = 2048;                              // of iq (R11)
constexpr int full_power_raw = 1000;                              // of MS motors
constexpr int motors_of_0x280 = 4;                                // L1143
constexpr Duration turn_of_0x280 = std::chrono::microseconds{10}; // ASSUMED: lower ids first (L1143)

const Family& family()
{
    static const Family& rmd = *find_family("rmd");
    return rmd;
}

int full_current_raw(const rmd::Spec& spec)
{
    return spec.model->iq == rmd::Iq::power ? full_power_raw : full_scale_raw;
}

double velocity_max_dps(const rmd::Spec& spec, const Rating& rating)
{
    return spec.device.max_speed_dps > 0.0 ? spec.device.max_speed_dps : units::deg(rating.velocity_max_rad_s);
}

} // namespace

// Where no document says what a raw unit is, full scale is all the current the motor takes.
RmdDevice::RmdDevice(const rmd::Spec& spec, const PlantParameters& plant)
    : Device(plant, spec.device.start_rad), spec_(std::make_unique<rmd::Spec>(spec)), id_(spec.id),
      options_(spec.profile.options()), motor_(spec, plant_),
      iq_a_(spec.iq_a().value_or(motor_.rating().current_max_a / full_current_raw(spec)))
{
    rom_ = delivered_memory(spec, velocity_max_dps(spec, motor_.rating()), full_current_raw(spec));
    plant_.heat_to(spec.device.temperature_c);
}

void RmdDevice::power_on()
{
    ram_ = rom_;
    acceleration_dps_s_ = static_cast<std::int32_t>(spec_->device.max_acceleration_dps_s);
    latched_errors_ = errors();
    motor_.engage_brake(false);
    motor_.power_on(rom_.encoder_offset, was_on_ && spec_->device.turns_kept);
    was_on_ = true;
}

void RmdDevice::control()
{
    latched_errors_ |= errors();
    if (latched_errors_ != 0 && spec_->device.stops_on_fault)
        motor_.off();
    motor_.control();
}

const wire::Protocol& RmdDevice::protocol() const
{
    return rmd::protocol();
}

void RmdDevice::answered(TimePoint) {}

void RmdDevice::tell(Look& look) const
{
    constexpr std::string_view words[] = {"",    "low voltage",      "high voltage",      "voltage",
                                          "hot", "low voltage, hot", "high voltage, hot", "voltage, hot"};
    look.mode = motor_.mode();
    look.temperature_c = plant_.winding_c();
    const unsigned hot = (latched_errors_ & rmd_over_temperature) != 0 ? 4U : 0U;
    look.faults = words[(latched_errors_ & (rmd_low_voltage | rmd_high_voltage)) | hot];
}

bool RmdDevice::set_dip(int id)
{
    constexpr int most = 8; // L112-123
    const bool known = 1 <= id && id <= most;
    if (known)
        id_ = id;
    return known;
}

std::optional<Answer> RmdDevice::hear(const wire::Frame& request, TimePoint at)
{
    const auto* message = protocol().identify(request, wire::Direction::request, spec_->profile.line);
    if (message == nullptr)
        return answer_unknown(request);
    switch (spec_->profile.dialect) {
    case rmd::Dialect::manual:
        return sim::serve(*this, manual_services, message, request, at);
    case rmd::Dialect::lk:
        return sim::serve(*this, lk_2_35_services, message, request, at);
    case rmd::Dialect::lk_2_36:
        return sim::serve(*this, lk_2_36_services, message, request, at);
    case rmd::Dialect::gyems:
        return sim::serve(*this, gyems_services, message, request, at);
    case rmd::Dialect::myactuator:
        return sim::serve(*this, myactuator_services, message, request, at);
    }
    return {};
}

template <class M>
std::optional<Answer> RmdDevice::serve(const wire::Frame& frame, TimePoint)
{
    const auto request = wire::decode_request<M>(frame, options_);
    if (!request)
        return {};
    constexpr const wire::MessageInfo& message = wire::info_of<M>;
    Duration earlier{};
    if constexpr (message.request.layout->can_fixed) {
        earlier = (motors_of_0x280 - id()) * turn_of_0x280;
        if (!spec_->device.multi_motor || id() > motors_of_0x280)
            return {};
    } else if (request->id != id()) {
        return {};
    }
    const Moment now = moment();
    told_ = spec_->device.reply_lag ? last_ : now;
    last_ = now;
    const auto reply = handle(request->message);
    if (!reply)
        return {};
    if constexpr (message.info.access == wire::Access::flash)
        ++flash_writes_;
    if constexpr (message.reply.exists())
        if (const auto encoded = wire::encode_reply<M>(id(), *reply, options_))
            return Answer{*encoded, family().response_time.typical - earlier};
    return {};
}

// GUESS (R43).
std::optional<Answer> RmdDevice::answer_unknown(const wire::Frame& request) const
{
    if (!spec_->device.echoes_unknown || request.can_id != rmd::identifier_base + static_cast<std::uint32_t>(id()))
        return {};
    wire::Frame echo = request;
    echo.can_id = spec_->profile.reply_identifier_base + static_cast<std::uint32_t>(id());
    return Answer{echo, family().response_time.typical};
}

// ---- parameters ----

void RmdDevice::write(rmd::ParameterId id, std::uint64_t value, bool rom)
{
    ram_.parameter(id) = parameter_bits(id, value);
    if (rom)
        rom_.parameter(id) = ram_.parameter(id);
}

Handled<rmd::ReadParameter> RmdDevice::handle(const rmd::ReadParameter& m)
{
    return rmd::ParameterValue{m.param_id, ram_.parameter(m.param_id)};
}

// GUESS (R18): writing never fails.
Handled<rmd::WriteParameterRam> RmdDevice::handle(const rmd::WriteParameterRam& m)
{
    write(m.param_id, m.value, false);
    return rmd::ParameterResult{static_cast<std::uint8_t>(m.param_id), 0};
}

Handled<rmd::WriteParameterRom> RmdDevice::handle(const rmd::WriteParameterRom& m)
{
    write(m.param_id, m.value, true);
    return rmd::ParameterResult{static_cast<std::uint8_t>(m.param_id), 0};
}

Handled<rmd::ReadAcceleration> RmdDevice::handle(const rmd::ReadAcceleration&)
{
    return rmd::Acceleration{acceleration_dps_s_};
}

Handled<rmd::WriteAccelerationRam> RmdDevice::handle(const rmd::WriteAccelerationRam& m)
{
    acceleration_dps_s_ = m.acceleration;
    return rmd::Acceleration{acceleration_dps_s_};
}

Handled<rmd::gyems::ReadPid> RmdDevice::handle(const rmd::gyems::ReadPid&)
{
    return ram_.pid;
}

Handled<rmd::gyems::WritePidRam> RmdDevice::handle(const rmd::gyems::WritePidRam& m)
{
    ram_.pid = {m.angle_kp, m.angle_ki, m.speed_kp, m.speed_ki, m.current_kp, m.current_ki};
    return ram_.pid;
}

Handled<rmd::gyems::WritePidRom> RmdDevice::handle(const rmd::gyems::WritePidRom& m)
{
    rom_.pid = {m.angle_kp, m.angle_ki, m.speed_kp, m.speed_ki, m.current_kp, m.current_ki};
    ram_.pid = rom_.pid;
    return ram_.pid;
}

} // namespace sinew::sim
