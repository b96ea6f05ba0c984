#pragma once
#include "sinew/family/rmd/gyems.hpp"
#include "sinew/family/rmd/lk.hpp"
#include "sinew/family/rmd/myactuator.hpp"

/// What exists on each firmware line of an RMD. A message that differs from the manual's as a whole keeps the name it
/// has there where it is the same thing. Sources: the vendor documents and drivers listed in README.md; what they leave
/// unclear is not here, and so a profile refuses it.
namespace sinew::rmd {

/// Of the manual, LK V2.35 has neither 0x33/0x34 nor 0x40-0x44; its 0xB0/0xB1 have no known layout. 0x280 is from older
/// documents and working drivers.
using Lk235Messages =
    MessageList<ReadEncoder, WriteEncoderOffset, WriteCurrentPositionZeroRom, ReadMultiTurnAngle,
                lk::ReadSingleTurnAngle, lk::SetCurrentAngle, lk::ReadStatus1, lk::ClearError, ReadStatus2,
                lk::ReadStatus3, MotorOff, MotorStop, MotorRunning, lk::BrakeControl, TorqueOpenLoop, TorqueClosedLoop,
                SpeedClosedLoop, lk::SpeedClosedLoopTorque, MultiLoopAngle, MultiLoopAngleSpeed, lk::SingleLoopAngle,
                lk::SingleLoopAngleSpeed, IncrementAngle, IncrementAngleSpeed, MultiMotorTorque>;

/// As V2.35 without 0x91 and 0xAD; 0xC0/0xC1 have no known layout.
using Lk236Messages =
    MessageList<ReadEncoder, WriteCurrentPositionZeroRom, ReadMultiTurnAngle, lk::ReadSingleTurnAngle,
                lk::SetCurrentAngle, lk_2_36::ReadStatus1, lk_2_36::ClearError, ReadStatus2, lk::ReadStatus3, MotorOff,
                MotorStop, MotorRunning, lk::BrakeControl, TorqueOpenLoop, TorqueClosedLoop, lk_2_36::SpeedClosedLoop,
                MultiLoopAngle, MultiLoopAngleSpeed, lk::SingleLoopAngle, lk::SingleLoopAngleSpeed, IncrementAngle,
                IncrementAngleSpeed, MultiMotorTorque>;

using Gyems162Messages =
    MessageList<gyems::ReadPid, gyems::WritePidRam, gyems::WritePidRom, ReadAcceleration, WriteAccelerationRam,
                ReadEncoder, WriteEncoderOffset, WriteCurrentPositionZeroRom, ReadMultiTurnAngle, ReadSingleTurnAngle,
                ReadStatus1, ClearError, ReadStatus2, ReadStatus3, MotorOff, MotorStop, MotorRunning,
                gyems::TorqueClosedLoop, SpeedClosedLoop, MultiLoopAngle, MultiLoopAngleSpeed, SingleLoopAngle,
                SingleLoopAngleSpeed, MultiMotorTorque>;

/// What V3.6 and V4.2 have in common; gains and accelerations changed their layout between the two.
using MyActuator3Messages =
    MessageList<ReadEncoder, myactuator::ReadMultiTurnAngle, ReadSingleTurnAngle, myactuator::ReadStatus1,
                myactuator::ReadStatus2, myactuator::ReadStatus3, myactuator::SystemReset, myactuator::BrakeRelease,
                myactuator::BrakeLock, MotorOff, MotorStop, myactuator::TorqueClosedLoop, myactuator::SpeedClosedLoop,
                myactuator::MultiLoopAngleSpeed, myactuator::IncrementAngleSpeed>;

inline constexpr auto lk_2_35_messages = catalogue(Lk235Messages{});
inline constexpr auto lk_2_36_messages = catalogue(Lk236Messages{});
inline constexpr auto gyems_1_62_messages = catalogue(Gyems162Messages{});
inline constexpr auto myactuator_3_messages = catalogue(MyActuator3Messages{});

} // namespace sinew::rmd
