#pragma once
#include "sinew/family/sam/messages.hpp"
#include "sinew/family/sam/models.hpp"
#include "sinew/sim/firmware/device.hpp"
#include "sinew/sim/firmware/dispatch.hpp"
#include "sinew/sim/firmware/sam_motion.hpp"
#include "sinew/sim/firmware/sam_program.hpp"
#include "sinew/sim/firmware/sam_protection.hpp"
#include "sinew/sim/firmware/sam_settings.hpp"
#include "sinew/sim/firmware/stored.hpp"

#include <optional>

namespace sinew::sim {

/// The firmware of one SAM. It answers as its response level says (A.2), and it is silent about what it does not
/// understand (S75), what its model does not have, and values that make no sense.
class SamDevice final : public Device
{
public:
    SamDevice(const sam::Spec& spec, const PlantParameters& plant);

    std::optional<Answer> hear(const wire::Frame& request, TimePoint at) override;
    const wire::Protocol& protocol() const override;
    void answered(TimePoint at) override;
    bool hears_all() const override { return spec_.device.ping_ignores_id; }

    std::uint32_t flash_writes() const override { return stored_.writes(); }
    std::vector<KeptValue> kept() const override;
    std::expected<void, Error> restore(const config::FlashFile& file, const config::FlashJoint& joint) override;
    const SamSettings& settings() const { return stored_.used; }

    /// What its LEDs show and its digital outputs put out; the protections have the LEDs too.
    sam::ExternalPort port() const;
    /// What stands at the AD input of its external port, 0 … 5.5 V.
    void set_external(double voltage_v);
    /// The switch inside. Held for 5 s it takes an encoder model back to ID 0 and 1.5 Mbps (L273, S48).
    void press_reset(Duration held);

    template <class M>
    std::optional<Answer> serve(const wire::Frame& frame, TimePoint at);

private:
    void power_on() override;
    void control() override;
    std::uint32_t set_bit_rate() const override { return bit_rate_; }
    int set_id() const override { return stored_.used.id; }
    void tell(Look& look) const override;

    // Each returns the reply, or nothing when the device ignores the message. Replies of motion commands tell the state
    // before the motion (A.2).
    Handled<sam::QuickPositionControl> handle(const sam::QuickPositionControl&);
    Handled<sam::QuickReadStatus> handle(const sam::QuickReadStatus&);
    Handled<sam::QuickPassiveMode> handle(const sam::QuickPassiveMode&);
    Handled<sam::QuickWheelMode> handle(const sam::QuickWheelMode&);
    Handled<sam::QuickBrakeMode> handle(const sam::QuickBrakeMode&);
    Handled<sam::SpecialControl> handle(const sam::SpecialControl&);
    Handled<sam::PositionControl> handle(const sam::PositionControl&);
    Handled<sam::PrecisePositionControl> handle(const sam::PrecisePositionControl&);
    Handled<sam::OffsetControl> handle(const sam::OffsetControl&);

    Handled<sam::ReadCurrentSpeed> handle(const sam::ReadCurrentSpeed&);
    Handled<sam::ReadCurrentAccel> handle(const sam::ReadCurrentAccel&);
    Handled<sam::ReadCurrentLoad> handle(const sam::ReadCurrentLoad&);
    Handled<sam::ReadCurrentPosition> handle(const sam::ReadCurrentPosition&);
    Handled<sam::ReadPrecisePosition> handle(const sam::ReadPrecisePosition&);
    Handled<sam::ReadInputVoltage> handle(const sam::ReadInputVoltage&);
    Handled<sam::ReadTemperatureError> handle(const sam::ReadTemperatureError&);

    Handled<sam::QuickSetId> handle(const sam::QuickSetId&);
    Handled<sam::SetId> handle(const sam::SetId&);
    Handled<sam::QuickSetBaudRate> handle(const sam::QuickSetBaudRate&);
    Handled<sam::SetBaudRate> handle(const sam::SetBaudRate&);
    Handled<sam::SetDriveMode> handle(const sam::SetDriveMode&);
    Handled<sam::ReadDriveMode> handle(const sam::ReadDriveMode&);
    Handled<sam::Ping> handle(const sam::Ping&);
    Handled<sam::ReadFirmwareVersion> handle(const sam::ReadFirmwareVersion&);

    Handled<sam::QuickSetRuntimePdGain> handle(const sam::QuickSetRuntimePdGain&);
    Handled<sam::SetPdGain> handle(const sam::SetPdGain&);
    Handled<sam::ReadPdGain> handle(const sam::ReadPdGain&);
    Handled<sam::SetRuntimePdGain> handle(const sam::SetRuntimePdGain&);
    Handled<sam::SetIGain> handle(const sam::SetIGain&);
    Handled<sam::ReadIGain> handle(const sam::ReadIGain&);
    Handled<sam::SetRuntimeIGain> handle(const sam::SetRuntimeIGain&);
    Handled<sam::SetAvgTorque> handle(const sam::SetAvgTorque&);
    Handled<sam::ReadAvgTorque> handle(const sam::ReadAvgTorque&);
    Handled<sam::QuickSetOverload> handle(const sam::QuickSetOverload&);
    Handled<sam::QuickReadOverload> handle(const sam::QuickReadOverload&);
    Handled<sam::SetOverload> handle(const sam::SetOverload&);
    Handled<sam::ReadOverload> handle(const sam::ReadOverload&);
    Handled<sam::QuickSetBoundary> handle(const sam::QuickSetBoundary&);
    Handled<sam::QuickReadBoundary> handle(const sam::QuickReadBoundary&);
    Handled<sam::SetBoundary> handle(const sam::SetBoundary&);
    Handled<sam::ReadBoundary> handle(const sam::ReadBoundary&);
    Handled<sam::SetCtrlSpeed> handle(const sam::SetCtrlSpeed&);
    Handled<sam::ReadCtrlSpeed> handle(const sam::ReadCtrlSpeed&);
    Handled<sam::SetCtrlTorque> handle(const sam::SetCtrlTorque&);
    Handled<sam::ReadCtrlTorque> handle(const sam::ReadCtrlTorque&);
    Handled<sam::SetCtrlAccel> handle(const sam::SetCtrlAccel&);
    Handled<sam::ReadCtrlAccel> handle(const sam::ReadCtrlAccel&);
    Handled<sam::SetCtrlDecel> handle(const sam::SetCtrlDecel&);
    Handled<sam::ReadCtrlDecel> handle(const sam::ReadCtrlDecel&);

    Handled<sam::QuickWriteExternalPort> handle(const sam::QuickWriteExternalPort&);
    Handled<sam::WriteExternalPort> handle(const sam::WriteExternalPort&);
    Handled<sam::QuickReadExternalAd> handle(const sam::QuickReadExternalAd&);
    Handled<sam::ReadExternalAd> handle(const sam::ReadExternalAd&);
    Handled<sam::QuickWriteMotionData> handle(const sam::QuickWriteMotionData&);
    Handled<sam::WriteMotionData> handle(const sam::WriteMotionData&);
    Handled<sam::QuickReadMotionData> handle(const sam::QuickReadMotionData&);
    Handled<sam::ReadMotionData> handle(const sam::ReadMotionData&);

    bool answers(const wire::MessageInfo& message, int response_level) const;
    void run_program();
    void perform(const SamProgram::Action& action);
    void quick_go_to(int torque_level, int target);
    void quick_wheel(double duty);
    std::uint8_t raw_id() const { return static_cast<std::uint8_t>(id()); }
    std::uint16_t raw_external() const;
    bool set_baud_code(int code);
    bool set_boundary(bool quick, int lower, int upper);
    std::uint8_t quick_position() const;

    sam::Spec spec_;
    wire::Options options_;
    Stored<SamSettings> stored_;
    SamRegisters registers_;
    SamMotion motion_;
    SamProtection protection_;
    SamProgram program_;
    double external_v_;
    std::uint32_t bit_rate_;
};

static_assert(sizeof(SamDevice) < 1536, "thousands of them fit into a cache");

} // namespace sinew::sim
