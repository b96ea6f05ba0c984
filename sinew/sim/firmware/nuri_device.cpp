#include "sinew/sim/firmware/nuri_device.hpp"

#include "sinew/base/units.hpp"
#include "sinew/family/families.hpp"
#include "sinew/family/nuri/framing.hpp"
#include "sinew/sim/firmware/ratings.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

constexpr auto manual_services = services<NuriDevice>(nuri::ManualMessages{});
constexpr auto mc_services = services<NuriDevice>(nuri::mc::Messages{});

constexpr int broadcast_id = 255;
constexpr double response_unit_us = 100.0; // L56
constexpr double current_lsb_a = 0.1;

const Family& family()
{
    static const Family& nuri = *find_family("nuri");
    return nuri;
}

std::uint8_t rated_current_raw(const nuri::Spec& spec)
{
    return static_cast<std::uint8_t>(std::clamp(std::lround(rating_of(spec).current_max_a / current_lsb_a), 1L, 255L));
}

bool is_mc(const nuri::Spec& spec)
{
    return spec.profile.line.messages.data() == nuri::mc::messages.data();
}

} // namespace

NuriSettings NuriDevice::factory_settings() const
{
    NuriSettings out;
    out.position.rated_current = out.speed.rated_current = rated_current_raw(spec_);
    return out;
}

NuriDevice::NuriDevice(const nuri::Spec& spec, const PlantParameters& plant)
    : Device(plant, spec.device.start_rad), spec_(spec), stored_(NuriSettings{}, 0), motion_(spec, plant_)
{
    NuriSettings& set = stored_.used;
    set = factory_settings();
    set.id = static_cast<std::uint8_t>(spec.id);
    set.bit_rate = spec.device.bit_rate;
    set.response_time =
        static_cast<std::uint8_t>(std::clamp(std::lround(spec.profile.response_time_us / response_unit_us), 0L, 254L));
    set.gear_ratio =
        static_cast<std::uint16_t>(std::clamp(std::lround(spec.profile.external_gear_ratio * 10.0), 1L, 65533L));
    stored_ = Stored<NuriSettings>(set, 0);
    id_ = set.id;
    bit_rate_ = set.bit_rate;
}

void NuriDevice::power_on()
{
    stored_.power_cycle();
    const NuriSettings& set = stored_.used;
    id_ = set.id;
    bit_rate_ = set.bit_rate;
    motion_.power_on(set.on, set.gear_ratio / 10.0, set.inverted && spec_.device.control_direction_works);
}

void NuriDevice::control()
{
    motion_.control();
}

const wire::Protocol& NuriDevice::protocol() const
{
    return nuri::protocol();
}

void NuriDevice::answered(TimePoint) {}

void NuriDevice::tell(Look& look) const
{
    look.mode = motion_.mode();
}

std::optional<Answer> NuriDevice::hear(const wire::Frame& request, TimePoint at)
{
    const auto* message = protocol().identify(request, wire::Direction::request, spec_.profile.line);
    if (message == nullptr)
        return {};
    return is_mc(spec_) ? sim::serve(*this, mc_services, message, request, at)
                        : sim::serve(*this, manual_services, message, request, at);
}

template <class M>
std::optional<Answer> NuriDevice::serve(const wire::Frame& frame, TimePoint)
{
    const auto request = wire::decode_request<M>(frame, spec_.profile.options());
    if (!request)
        return {};
    constexpr const wire::MessageInfo& message = wire::info_of<M>;
    const bool to_all = message.info.broadcast && request->id == broadcast_id;
    if (!to_all && request->id != id())
        return {};
    if constexpr (message.reply.exists()) {
        const auto encoded = wire::encode_reply<M>(id(), handle(request->message), spec_.profile.options());
        if (!encoded)
            return {};
        const double delay_us = stored_.used.response_time * response_unit_us;
        return Answer{*encoded, std::chrono::microseconds(std::lround(delay_us))};
    } else {
        const bool done = handle(request->message);
        if (done && message.info.access == wire::Access::flash && spec_.device.settings_persist)
            stored_.keep();
        return {};
    }
}

// ---- settings ----

// More than the product is rated for makes no sense to it (N19); GUESS: then it ignores the message.
bool NuriDevice::set_controller(NuriController& controller, const NuriController& to)
{
    if (to.rated_current > rated_current_raw(spec_))
        return false;
    controller = to;
    return true;
}

bool NuriDevice::handle(const nuri::SetPositionController& m)
{
    return set_controller(stored_.used.position,
                          {m.position_kp, m.position_ki, m.position_kd, m.position_rated_current});
}

bool NuriDevice::handle(const nuri::SetSpeedController& m)
{
    return set_controller(stored_.used.speed, {m.speed_kp, m.speed_ki, m.speed_kd, m.speed_rated_current});
}

// GUESS (N15): at once.
void NuriDevice::switch_bus()
{
    if (spec_.device.bus_switch == nuri::BusSwitch::at_power_on)
        return;
    id_ = stored_.used.id;
    bit_rate_ = stored_.used.bit_rate;
}

bool NuriDevice::handle(const nuri::SetId& m)
{
    stored_.used.id = m.new_id;
    switch_bus();
    return true;
}

bool NuriDevice::handle(const nuri::SetBaudRate& m)
{
    for (const BitRate& rate : family().bit_rates)
        if (rate.code == m.baud_code) {
            stored_.used.bit_rate = rate.bps;
            switch_bus();
            return true;
        }
    return false;
}

bool NuriDevice::handle(const nuri::SetResponseTime& m)
{
    stored_.used.response_time = m.response_time;
    return true;
}

bool NuriDevice::set_gear_ratio(std::uint16_t tenths)
{
    stored_.used.gear_ratio = tenths;
    motion_.gear(tenths / 10.0);
    return true;
}

bool NuriDevice::handle(const nuri::SetExternalGearRatio& m)
{
    return set_gear_ratio(m.gear_ratio);
}

bool NuriDevice::handle(const nuri::mc::SetExternalGearRatio& m)
{
    return set_gear_ratio(m.gear_ratio);
}

bool NuriDevice::set_control(nuri::Control control)
{
    stored_.used.on = control == nuri::Control::on;
    motion_.control(stored_.used.on);
    return true;
}

bool NuriDevice::handle(const nuri::SetControlOnOff& m)
{
    return set_control(m.control);
}

bool NuriDevice::handle(const nuri::mc::SetControlOnOff& m)
{
    return set_control(m.control);
}

bool NuriDevice::set_relative(nuri::PositionMode mode)
{
    stored_.used.relative = mode == nuri::PositionMode::relative;
    return true;
}

bool NuriDevice::handle(const nuri::SetPositionControlMode& m)
{
    return set_relative(m.position_mode);
}

bool NuriDevice::handle(const nuri::mc::SetPositionControlMode& m)
{
    return set_relative(m.position_mode);
}

bool NuriDevice::set_inverted(bool inverted)
{
    stored_.used.inverted = inverted;
    motion_.invert(inverted && spec_.device.control_direction_works);
    return true;
}

bool NuriDevice::handle(const nuri::SetControlDirection& m)
{
    return set_inverted(m.control_direction == 1);
}

bool NuriDevice::handle(const nuri::mc::SetControlDirection& m)
{
    return set_inverted(m.control_direction == nuri::Rotation::clockwise);
}

bool NuriDevice::handle(const nuri::mc::SetRatedSpeed& m)
{
    stored_.used.rated_speed = m.rated_speed;
    return true;
}

bool NuriDevice::handle(const nuri::mc::SetResolution& m)
{
    stored_.used.resolution = m.resolution;
    return true;
}

// GUESS (N24): everything, id and bit rate among it.
bool NuriDevice::handle(const nuri::FactoryReset&)
{
    const NuriSettings before = stored_.used;
    stored_.used = factory_settings();
    if (spec_.device.reset_keeps_bus) {
        stored_.used.id = before.id;
        stored_.used.bit_rate = before.bit_rate;
    }
    switch_bus();
    motion_.gear(stored_.used.gear_ratio / 10.0);
    motion_.invert(false);
    motion_.control(true);
    return true;
}

bool NuriDevice::handle(const nuri::mc::FactoryReset&)
{
    return handle(nuri::FactoryReset{});
}

} // namespace sinew::sim
