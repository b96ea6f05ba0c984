#pragma once
#include "sinew/family/nuri/lines.hpp"
#include "sinew/family/nuri/models.hpp"
#include "sinew/sim/firmware/device.hpp"
#include "sinew/sim/firmware/dispatch.hpp"
#include "sinew/sim/firmware/nuri_motion.hpp"
#include "sinew/sim/firmware/nuri_settings.hpp"
#include "sinew/sim/firmware/stored.hpp"

#include <optional>

namespace sinew::sim {

/// The firmware of one Nuri of either line. It obeys commands without a word, also those to all devices, and answers
/// feedback requests to its own id after its response time.
class NuriDevice final : public Device
{
public:
    NuriDevice(const nuri::Spec& spec, const PlantParameters& plant);

    std::optional<Answer> hear(const wire::Frame& request, TimePoint at) override;
    const wire::Protocol& protocol() const override;
    void answered(TimePoint at) override;

    std::uint32_t flash_writes() const override { return stored_.writes(); }
    std::vector<KeptValue> kept() const override;
    std::expected<void, Error> restore(const config::FlashFile& file, const config::FlashJoint& joint) override;
    const NuriSettings& settings() const { return stored_.used; }

    template <class M>
    std::optional<Answer> serve(const wire::Frame& frame, TimePoint at);

private:
    void power_on() override;
    void control() override;
    std::uint32_t set_bit_rate() const override { return bit_rate_; }
    int set_id() const override { return id_; }
    void tell(Look& look) const override;

    // Commands: false when the device ignores the message.
    bool handle(const nuri::PositionSpeedControl&);
    bool handle(const nuri::AccelPositionControl&);
    bool handle(const nuri::AccelSpeedControl&);
    bool handle(const nuri::SetPositionController&);
    bool handle(const nuri::SetSpeedController&);
    bool handle(const nuri::SetId&);
    bool handle(const nuri::SetBaudRate&);
    bool handle(const nuri::SetResponseTime&);
    bool handle(const nuri::SetExternalGearRatio&);
    bool handle(const nuri::SetControlOnOff&);
    bool handle(const nuri::SetPositionControlMode&);
    bool handle(const nuri::ResetPosition&);
    bool handle(const nuri::FactoryReset&);
    bool handle(const nuri::SetControlDirection&);
    bool handle(const nuri::mc::SetRatedSpeed&);
    bool handle(const nuri::mc::SetResolution&);
    bool handle(const nuri::mc::SetExternalGearRatio&);
    bool handle(const nuri::mc::SetControlOnOff&);
    bool handle(const nuri::mc::SetPositionControlMode&);
    bool handle(const nuri::mc::SetControlDirection&);
    bool handle(const nuri::mc::ResetPosition&);
    bool handle(const nuri::mc::FactoryReset&);

    // Feedback requests: the answer.
    nuri::ReplyPing handle(const nuri::RequestPing&);
    nuri::ReplyPositionFeedback handle(const nuri::RequestPositionFeedback&);
    nuri::ReplySpeedFeedback handle(const nuri::RequestSpeedFeedback&);
    nuri::ReplyPositionControllerFeedback handle(const nuri::RequestPositionControllerFeedback&);
    nuri::ReplySpeedControllerFeedback handle(const nuri::RequestSpeedControllerFeedback&);
    nuri::ReplyResponseTimeFeedback handle(const nuri::RequestResponseTimeFeedback&);
    nuri::ReplyGearRatioFeedback handle(const nuri::RequestGearRatioFeedback&);
    nuri::ReplyControlOnOffFeedback handle(const nuri::RequestControlOnOffFeedback&);
    nuri::ReplyPositionModeFeedback handle(const nuri::RequestPositionModeFeedback&);
    nuri::ReplyFirmwareVersionFeedback handle(const nuri::RequestFirmwareVersionFeedback&);
    nuri::mc::ReplyRatedSpeedFeedback handle(const nuri::mc::RequestRatedSpeedFeedback&);
    nuri::mc::ReplyResolutionFeedback handle(const nuri::mc::RequestResolutionFeedback&);
    nuri::mc::ReplyGearRatioFeedback handle(const nuri::mc::RequestGearRatioFeedback&);
    nuri::mc::ReplyControlOnOffFeedback handle(const nuri::mc::RequestControlOnOffFeedback&);
    nuri::mc::ReplyPositionModeFeedback handle(const nuri::mc::RequestPositionModeFeedback&);
    nuri::mc::ReplyControlDirectionFeedback handle(const nuri::mc::RequestControlDirectionFeedback&);

    NuriSettings factory_settings() const;
    void switch_bus();
    bool set_controller(NuriController& controller, const NuriController& to);
    bool set_gear_ratio(std::uint16_t tenths);
    bool set_control(nuri::Control control);
    bool set_inverted(bool inverted);
    bool set_relative(nuri::PositionMode mode);
    double sense(nuri::Rotation direction) const;
    nuri::Rotation direction_of(double value) const;
    double target_rad(nuri::Rotation direction, std::uint16_t position) const;
    std::uint16_t raw_position(double lsb_deg) const;
    std::uint16_t raw_speed() const;
    std::uint8_t raw_current() const;

    nuri::Spec spec_;
    Stored<NuriSettings> stored_;
    NuriMotion motion_;
    std::uint8_t id_ = 0; ///< in use, and the rate
    std::uint32_t bit_rate_ = 0;
};

static_assert(sizeof(NuriDevice) < 2048);

} // namespace sinew::sim
