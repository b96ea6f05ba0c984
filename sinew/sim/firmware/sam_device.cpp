#include "sinew/sim/firmware/sam_device.hpp"

#include "sinew/family/families.hpp"
#include "sinew/family/sam/framing.hpp"

namespace sinew::sim {
namespace {

constexpr std::uint32_t factory_bit_rate = 1'500'000; // L273

constexpr auto all_services = services<SamDevice>(sam::ManualMessages{});

const Family& family()
{
    static const Family& sam = *find_family("sam");
    return sam;
}

SamSettings delivered(const sam::Spec& spec)
{
    SamSettings out;
    out.id = static_cast<std::uint8_t>(spec.id);
    out.bit_rate = spec.device.bit_rate;
    out.response_level = spec.device.response_level;
    out.reverse = spec.device.reverse;
    return out;
}

/// Every repeat of a value made that value, so that the codec finds nothing to refuse (S79).
template <class M>
wire::Frame without_differing_repeats(wire::Frame frame)
{
    for (const wire::Field& field : wire::info_of<M>.request.fields)
        if (field.kind == wire::Kind::repeat)
            frame.data[field.byte] = frame.data[field.source];
    frame.data[frame.size - 1U] = wire::checksum(wire::Checksum::xor7, frame.data.data(), frame.size);
    return frame;
}

} // namespace

SamDevice::SamDevice(const sam::Spec& spec, const PlantParameters& plant)
    : Device(plant, spec.device.start_rad), spec_(spec), options_(spec.profile.options()),
      stored_(delivered(spec), spec.device.flash_writes_max), motion_(spec, plant_),
      external_v_(spec.device.external_v), bit_rate_(spec.device.bit_rate)
{
    plant_.heat_to(spec.device.temperature_c);
}

void SamDevice::power_on()
{
    stored_.power_cycle();
    registers_ = {};
    registers_.gains = stored_.used.gains;
    const auto port = static_cast<unsigned>(spec_.device.port_at_power_on);
    registers_.port = {(port & 1U) != 0, (port & 2U) != 0, (port & 4U) != 0, (port & 8U) != 0};
    bit_rate_ = stored_.used.bit_rate;
    motion_.reverse(stored_.used.reverse && spec_.device.reverse_works);
    motion_.power_on();
    protection_.power_on();
    program_.start(stored_.used.motion, stored_.used.motion_count, spec_.device);
}

void SamDevice::control()
{
    const SamProtection::Limits limits{.overload_a = stored_.used.overload * spec_.model->current_a_per_ad12,
                                       .fixed_a = spec_.device.fixed_overload_a,
                                       .hysteresis_k = spec_.device.overheat_hysteresis_k};
    const bool tripped = protection_.control(plant_.current_a(), plant_.case_c(), motion_.is_driving(), limits);
    if (tripped && spec_.device.overload_resume == sam::OverloadResume::stay_passive) {
        program_.stop();
        motion_.passive();
    }
    run_program();
    const bool too_hot = protection_.is_hot() && motion_.mode() == sam::Mode::position; // L714
    motion_.control(!too_hot && !protection_.is_passive(), registers_.gains);
}

const wire::Protocol& SamDevice::protocol() const
{
    return sam::protocol();
}

void SamDevice::tell(Look& look) const
{
    look.mode = to_word(protection_.is_passive() ? sam::Mode::passive : motion_.mode());
    look.faults = protection_.faults();
    if (look.faults.empty() && stored_.worn_out())
        look.faults = "flash worn out";
}

void SamDevice::press_reset(Duration held)
{
    if (!is_on() || !spec_.model->encoder || held < std::chrono::seconds{5})
        return;
    stored_.used.id = 0;
    stored_.used.bit_rate = bit_rate_ = factory_bit_rate;
    stored_.keep();
}

std::optional<Answer> SamDevice::hear(const wire::Frame& request, TimePoint at)
{
    const auto* message = protocol().identify(request, wire::Direction::request, spec_.profile.line);
    if (message == nullptr || !sam::offers(*spec_.model, *message))
        return {};
    return sim::serve(*this, all_services, message, request, at);
}

bool SamDevice::answers(const wire::MessageInfo& message, int response_level) const
{
    const bool as_command =
        message.info.answered_as_command || (&message == &wire::info_of<sam::Ping> && !spec_.profile.ping_is_read);
    return response_level == 1 || (response_level == 0 && !as_command);
}

template <class M>
std::optional<Answer> SamDevice::serve(const wire::Frame& frame, TimePoint at)
{
    const auto request =
        wire::decode_request<M>(spec_.device.repeats_checked ? frame : without_differing_repeats<M>(frame), options_);
    if (!request)
        return {};
    constexpr const wire::MessageInfo& message = wire::info_of<M>;
    const bool to_all = message.info.broadcast && request->id == sam::quick_all.ids.high;
    const bool to_any = std::is_same_v<M, sam::Ping> && spec_.device.ping_ignores_id;
    if (!to_all && !to_any && request->id != id())
        return {};

    const int level_before = stored_.used.response_level;
    const auto reply = handle(request->message);
    if (!reply)
        return {};
    if constexpr (message.info.access == wire::Access::flash)
        stored_.keep();

    std::optional<Answer> answer;
    const bool by_old_level =
        std::is_same_v<M, sam::SetDriveMode> && spec_.device.drive_mode_reply == sam::DriveModeReply::old_level;
    const bool may_answer = !to_all || spec_.device.brake_broadcast_reply;
    if (may_answer && answers(message, by_old_level ? level_before : stored_.used.response_level))
        if (const auto encoded = wire::encode_reply<M>(id(), *reply, options_))
            answer = Answer{*encoded, family().response_time.typical};
    if (!answer)
        answered(at);
    return answer;
}

// GUESS (S70): the reply still goes out at the old rate.
void SamDevice::answered(TimePoint)
{
    if (spec_.device.baud_switch == sam::BaudSwitch::after_reply)
        bit_rate_ = stored_.used.bit_rate;
}

// ---- what the device is called and how it speaks ----

Handled<sam::QuickSetId> SamDevice::handle(const sam::QuickSetId& m)
{
    if (spec_.profile.quick_id_strict && m.new_id > sam::quick.ids.high)
        return {};
    stored_.used.id = m.new_id; // GUESS (S70): it counts at once
    return sam::NewId{m.new_id};
}

Handled<sam::SetId> SamDevice::handle(const sam::SetId& m)
{
    stored_.used.id = m.new_id;
    return sam::NewId{m.new_id};
}

bool SamDevice::set_baud_code(int code)
{
    for (const BitRate& rate : family().bit_rates)
        if (rate.code == code) {
            stored_.used.bit_rate = rate.bps;
            return true;
        }
    return false;
}

Handled<sam::QuickSetBaudRate> SamDevice::handle(const sam::QuickSetBaudRate& m)
{
    if (!set_baud_code(m.baud_code))
        return {};
    return sam::NewBaudRate{m.baud_code};
}

Handled<sam::SetBaudRate> SamDevice::handle(const sam::SetBaudRate& m)
{
    if (!set_baud_code(m.baud_code))
        return {};
    return sam::NewBaudRate{m.baud_code};
}

Handled<sam::SetDriveMode> SamDevice::handle(const sam::SetDriveMode& m)
{
    stored_.used.response_level = m.response_level;
    stored_.used.reverse = m.reverse;
    motion_.reverse(m.reverse && spec_.device.reverse_works);
    return sam::DriveMode{m.response_level, m.reverse};
}

Handled<sam::ReadDriveMode> SamDevice::handle(const sam::ReadDriveMode&)
{
    return sam::DriveMode{static_cast<std::uint8_t>(stored_.used.response_level), stored_.used.reverse};
}

Handled<sam::Ping> SamDevice::handle(const sam::Ping&)
{
    return sam::Identity{raw_id()};
}

Handled<sam::ReadFirmwareVersion> SamDevice::handle(const sam::ReadFirmwareVersion&)
{
    constexpr std::uint8_t version = 3; // of the manual's example, `18 03`
    return sam::FirmwareVersion{spec_.model->number, version};
}

} // namespace sinew::sim
