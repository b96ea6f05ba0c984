#pragma once
#include "sinew/family/rmd/lines.hpp"
#include "sinew/family/rmd/models.hpp"
#include "sinew/sim/firmware/device.hpp"
#include "sinew/sim/firmware/dispatch.hpp"
#include "sinew/sim/firmware/rmd_memory.hpp"
#include "sinew/sim/firmware/rmd_motor.hpp"

#include <memory>
#include <optional>
#include <string_view>

namespace sinew::sim {

/// The firmware of one RMD of any of the five lines. It answers every message of its line with one frame, in every
/// state, and nothing else (R43).
class RmdDevice final : public Device
{
public:
    RmdDevice(const rmd::Spec& spec, const PlantParameters& plant);

    std::optional<Answer> hear(const wire::Frame& request, TimePoint at) override;
    const wire::Protocol& protocol() const override;
    /// As the first three switches of its board are set: an id of 1 … 8, which counts at once (GUESS). False: there is
    /// no such setting.
    bool set_dip(int id);
    void answered(TimePoint at) override;

    std::uint32_t flash_writes() const override { return flash_writes_; }
    std::vector<KeptValue> kept() const override;
    std::expected<void, Error> restore(const config::FlashFile& file, const config::FlashJoint& joint) override;

    template <class M>
    std::optional<Answer> serve(const wire::Frame& frame, TimePoint at);

private:
    void power_on() override;
    void control() override;
    std::uint32_t set_bit_rate() const override { return spec_->device.bit_rate; }
    int set_id() const override { return id_; }
    void tell(Look& look) const override;

    // Settings.
    Handled<rmd::ReadParameter> handle(const rmd::ReadParameter&);
    Handled<rmd::WriteParameterRam> handle(const rmd::WriteParameterRam&);
    Handled<rmd::WriteParameterRom> handle(const rmd::WriteParameterRom&);
    Handled<rmd::ReadAcceleration> handle(const rmd::ReadAcceleration&);
    Handled<rmd::WriteAccelerationRam> handle(const rmd::WriteAccelerationRam&);
    Handled<rmd::gyems::ReadPid> handle(const rmd::gyems::ReadPid&);
    Handled<rmd::gyems::WritePidRam> handle(const rmd::gyems::WritePidRam&);
    Handled<rmd::gyems::WritePidRom> handle(const rmd::gyems::WritePidRom&);

    // Angles and their zero.
    Handled<rmd::ReadEncoder> handle(const rmd::ReadEncoder&);
    Handled<rmd::WriteEncoderOffset> handle(const rmd::WriteEncoderOffset&);
    Handled<rmd::WriteCurrentPositionZeroRom> handle(const rmd::WriteCurrentPositionZeroRom&);
    Handled<rmd::ReadMultiTurnAngle> handle(const rmd::ReadMultiTurnAngle&);
    Handled<rmd::myactuator::ReadMultiTurnAngle> handle(const rmd::myactuator::ReadMultiTurnAngle&);
    Handled<rmd::ReadSingleTurnAngle> handle(const rmd::ReadSingleTurnAngle&);
    Handled<rmd::lk::ReadSingleTurnAngle> handle(const rmd::lk::ReadSingleTurnAngle&);
    Handled<rmd::SetCurrentPositionZero> handle(const rmd::SetCurrentPositionZero&);
    Handled<rmd::lk::SetCurrentAngle> handle(const rmd::lk::SetCurrentAngle&);

    // States.
    Handled<rmd::ReadStatus1> handle(const rmd::ReadStatus1&);
    Handled<rmd::lk::ReadStatus1> handle(const rmd::lk::ReadStatus1&);
    Handled<rmd::lk_2_36::ReadStatus1> handle(const rmd::lk_2_36::ReadStatus1&);
    Handled<rmd::myactuator::ReadStatus1> handle(const rmd::myactuator::ReadStatus1&);
    Handled<rmd::ClearError> handle(const rmd::ClearError&);
    Handled<rmd::lk::ClearError> handle(const rmd::lk::ClearError&);
    Handled<rmd::lk_2_36::ClearError> handle(const rmd::lk_2_36::ClearError&);
    Handled<rmd::ReadStatus2> handle(const rmd::ReadStatus2&);
    Handled<rmd::myactuator::ReadStatus2> handle(const rmd::myactuator::ReadStatus2&);
    Handled<rmd::ReadStatus3> handle(const rmd::ReadStatus3&);
    Handled<rmd::lk::ReadStatus3> handle(const rmd::lk::ReadStatus3&);
    Handled<rmd::myactuator::ReadStatus3> handle(const rmd::myactuator::ReadStatus3&);

    // On, off, brake.
    Handled<rmd::MotorOff> handle(const rmd::MotorOff&);
    Handled<rmd::MotorStop> handle(const rmd::MotorStop&);
    Handled<rmd::MotorRunning> handle(const rmd::MotorRunning&);
    Handled<rmd::lk::BrakeControl> handle(const rmd::lk::BrakeControl&);
    Handled<rmd::myactuator::BrakeRelease> handle(const rmd::myactuator::BrakeRelease&);
    Handled<rmd::myactuator::BrakeLock> handle(const rmd::myactuator::BrakeLock&);
    Handled<rmd::myactuator::SystemReset> handle(const rmd::myactuator::SystemReset&);

    // Motion.
    Handled<rmd::TorqueOpenLoop> handle(const rmd::TorqueOpenLoop&);
    Handled<rmd::TorqueClosedLoop> handle(const rmd::TorqueClosedLoop&);
    Handled<rmd::gyems::TorqueClosedLoop> handle(const rmd::gyems::TorqueClosedLoop&);
    Handled<rmd::myactuator::TorqueClosedLoop> handle(const rmd::myactuator::TorqueClosedLoop&);
    Handled<rmd::MultiMotorTorque> handle(const rmd::MultiMotorTorque&);
    Handled<rmd::SpeedClosedLoop> handle(const rmd::SpeedClosedLoop&);
    Handled<rmd::lk::SpeedClosedLoopTorque> handle(const rmd::lk::SpeedClosedLoopTorque&);
    Handled<rmd::lk_2_36::SpeedClosedLoop> handle(const rmd::lk_2_36::SpeedClosedLoop&);
    Handled<rmd::myactuator::SpeedClosedLoop> handle(const rmd::myactuator::SpeedClosedLoop&);
    Handled<rmd::MultiLoopAngle> handle(const rmd::MultiLoopAngle&);
    Handled<rmd::MultiLoopAngleSpeed> handle(const rmd::MultiLoopAngleSpeed&);
    Handled<rmd::myactuator::MultiLoopAngleSpeed> handle(const rmd::myactuator::MultiLoopAngleSpeed&);
    Handled<rmd::SingleLoopAngle> handle(const rmd::SingleLoopAngle&);
    Handled<rmd::lk::SingleLoopAngle> handle(const rmd::lk::SingleLoopAngle&);
    Handled<rmd::SingleLoopAngleSpeed> handle(const rmd::SingleLoopAngleSpeed&);
    Handled<rmd::lk::SingleLoopAngleSpeed> handle(const rmd::lk::SingleLoopAngleSpeed&);
    Handled<rmd::IncrementAngle> handle(const rmd::IncrementAngle&);
    Handled<rmd::IncrementAngleSpeed> handle(const rmd::IncrementAngleSpeed&);
    Handled<rmd::myactuator::IncrementAngleSpeed> handle(const rmd::myactuator::IncrementAngleSpeed&);

    std::optional<Answer> answer_unknown(const wire::Frame& request) const;
    double current_a(const wire::MessageInfo& message, std::string_view field, std::int64_t raw) const;
    /// Limits of the setting tool and of 0x34.
    RmdLimits tool_limits() const;
    RmdLimits limits(std::uint16_t max_speed) const;
    double inside_max_angle_rad(double multi_turn_rad) const;
    void write(rmd::ParameterId id, std::uint64_t value, bool rom);

    /// What a reply tells, at one moment.
    struct Moment {
        rmd::MotorState motor;
        rmd::myactuator::MotorState shaft;
    };
    Moment moment() const;
    /// What control commands are answered with: now, or the frame before.
    const Moment& told() const { return told_; }

    std::uint8_t errors() const;      ///< whose cause is there now
    std::uint8_t told_errors() const; ///< latched ones that the line has a bit for
    std::int8_t temperature() const;
    std::int16_t speed_dps() const;
    std::int16_t iq() const;
    rmd::Status1 status1() const;
    rmd::lk::Status1 lk_status1() const;
    rmd::PhaseCurrents phase_currents() const;

    std::unique_ptr<const rmd::Spec> spec_; ///< large and seldom looked at
    int id_;
    wire::Options options_;
    RmdMemory rom_;
    RmdMemory ram_;
    std::int32_t acceleration_dps_s_ = 0;
    std::uint8_t latched_errors_ = 0;
    bool was_on_ = false; ///< ever
    RmdMotor motor_;
    double iq_a_; ///< amperes per raw unit of `iq`
    Moment told_{};
    Moment last_{}; ///< at the frame before
    std::uint32_t flash_writes_ = 0;
};

static_assert(sizeof(RmdDevice) < 2048);

} // namespace sinew::sim
