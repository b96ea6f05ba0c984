#pragma once
#include "sinew/family/rmd/messages.hpp"

/// The messages whose layout differs on MyActuator RMD-X V3.6 to V4.2.
namespace sinew::rmd {

namespace myactuator {

struct MotorState {
    std::int8_t temperature{};
    std::int16_t iq{};
    std::int16_t speed{};
    std::int16_t shaft_angle{};
};
consteval auto motor_state()
{
    return side<MotorState>(command_frame, 8,
                            i8(&MotorState::temperature, {.name = "temperature", .byte = 1, .unit = "degC"}),
                            i16_le(&MotorState::iq, {.name = "iq", .byte = 2, .unit = "A", .scale = 0.01}),
                            i16_le(&MotorState::speed, {.name = "speed", .byte = 4, .unit = "dps"}),
                            i16_le(&MotorState::shaft_angle, {.name = "shaft_angle", .byte = 6, .unit = "deg"}));
}

struct ReadStatus1 {
};
struct Status1 {
    std::int8_t temperature{};
    bool brake_released{};
    std::uint16_t voltage{};
    std::uint16_t error_state{};
};
consteval auto row_of(const ReadStatus1*)
{
    return message<ReadStatus1, Status1>(
        {.name = "read-status1",
         .opcode = 0x9A,
         .manual = "RMD-X V3.6",
         .says = "Read temperature, brake, voltage and error flags."},
        bare_side<ReadStatus1>(),
        side<Status1>(
            command_frame, 8, i8(&Status1::temperature, {.name = "temperature", .byte = 1, .unit = "degC"}),
            reserved("reserved_2", 2),
            u8(&Status1::brake_released, {.name = "brake_released", .byte = 3, .range = {0, 1}}),
            u16_le(&Status1::voltage, {.name = "voltage", .byte = 4, .unit = "V", .scale = 0.1}),
            u16_le(&Status1::error_state, {.name = "error_state", .byte = 6, .says = "bits are kept as they are"})));
}

struct ReadStatus2 {
};
consteval auto row_of(const ReadStatus2*)
{
    return message<ReadStatus2, MotorState>({.name = "read-status2",
                                             .opcode = 0x9C,
                                             .manual = "RMD-X V3.6",
                                             .says = "Read temperature, torque current, speed and shaft angle."},
                                            bare_side<ReadStatus2>(), motor_state());
}

struct ReadStatus3 {
};
struct PhaseCurrents {
    std::int8_t temperature{};
    std::int16_t phase_a_current{};
    std::int16_t phase_b_current{};
    std::int16_t phase_c_current{};
};
consteval auto row_of(const ReadStatus3*)
{
    return message<ReadStatus3, PhaseCurrents>(
        {.name = "read-status3",
         .opcode = 0x9D,
         .manual = "RMD-X V3.6",
         .says = "Read temperature and the three phase currents."},
        bare_side<ReadStatus3>(),
        side<PhaseCurrents>(
            command_frame, 8, i8(&PhaseCurrents::temperature, {.name = "temperature", .byte = 1, .unit = "degC"}),
            i16_le(&PhaseCurrents::phase_a_current, {.name = "phase_a_current", .byte = 2, .unit = "A", .scale = 0.01}),
            i16_le(&PhaseCurrents::phase_b_current, {.name = "phase_b_current", .byte = 4, .unit = "A", .scale = 0.01}),
            i16_le(&PhaseCurrents::phase_c_current,
                   {.name = "phase_c_current", .byte = 6, .unit = "A", .scale = 0.01})));
}

struct ReadMultiTurnAngle {
};
struct MultiTurnAngle {
    std::int32_t angle{};
};
consteval auto row_of(const ReadMultiTurnAngle*)
{
    return message<ReadMultiTurnAngle, MultiTurnAngle>(
        {.name = "read-multi-turn-angle",
         .opcode = 0x92,
         .manual = "RMD-X V3.6",
         .errata = "R10",
         .says = "Read the angle over all turns."},
        bare_side<ReadMultiTurnAngle>(),
        side<MultiTurnAngle>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i32_le(&MultiTurnAngle::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})));
}

struct TorqueClosedLoop {
    std::int16_t iq{};
};
consteval auto row_of(const TorqueClosedLoop*)
{
    return message<TorqueClosedLoop, MotorState>(
        {.name = "torque-closed-loop",
         .opcode = 0xA1,
         .access = Access::command,
         .moves = true,
         .manual = "RMD-X V3.6",
         .says = "Drive with a given torque current."},
        side<TorqueClosedLoop>(command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
                               i16_le(&TorqueClosedLoop::iq, {.name = "iq", .byte = 4, .unit = "A", .scale = 0.01}),
                               reserved("null_6", 6), reserved("null_7", 7)),
        motor_state());
}

struct SpeedClosedLoop {
    std::int32_t speed{};
};
consteval auto row_of(const SpeedClosedLoop*)
{
    return message<SpeedClosedLoop, MotorState>(
        {.name = "speed-closed-loop",
         .opcode = 0xA2,
         .access = Access::command,
         .moves = true,
         .manual = "RMD-X V3.6",
         .says = "Turn at a given speed."},
        side<SpeedClosedLoop>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i32_le(&SpeedClosedLoop::speed, {.name = "speed", .byte = 4, .unit = "dps", .scale = 0.01})),
        motor_state());
}

struct MultiLoopAngleSpeed {
    std::uint16_t max_speed{};
    std::int32_t angle{};
};
consteval auto row_of(const MultiLoopAngleSpeed*)
{
    return message<MultiLoopAngleSpeed, MotorState>(
        {.name = "multi-loop-angle-speed",
         .opcode = 0xA4,
         .access = Access::command,
         .moves = true,
         .manual = "RMD-X V3.6",
         .errata = "R01",
         .says = "Go to an angle over all turns at a given speed at most."},
        side<MultiLoopAngleSpeed>(
            command_frame, 8, reserved("null_1", 1),
            u16_le(&MultiLoopAngleSpeed::max_speed, {.name = "max_speed", .byte = 2, .unit = "dps"}),
            i32_le(&MultiLoopAngleSpeed::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
        motor_state());
}

struct IncrementAngleSpeed {
    std::uint16_t max_speed{};
    std::int32_t angle{};
};
consteval auto row_of(const IncrementAngleSpeed*)
{
    return message<IncrementAngleSpeed, MotorState>(
        {.name = "increment-angle-speed",
         .opcode = 0xA8,
         .access = Access::command,
         .moves = true,
         .relative = true,
         .manual = "RMD-X V3.6",
         .errata = "R01 R29",
         .says = "Turn on by an angle at a given speed at most."},
        side<IncrementAngleSpeed>(
            command_frame, 8, reserved("null_1", 1),
            u16_le(&IncrementAngleSpeed::max_speed, {.name = "max_speed", .byte = 2, .unit = "dps"}),
            i32_le(&IncrementAngleSpeed::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
        motor_state());
}

struct BrakeRelease {
};
consteval auto row_of(const BrakeRelease*)
{
    return message<BrakeRelease, Acknowledged>({.name = "brake-release",
                                                .opcode = 0x77,
                                                .access = Access::command,
                                                .moves = true,
                                                .manual = "RMD-X V3.6",
                                                .says = "Release the holding brake."},
                                               bare_side<BrakeRelease>(), acknowledged());
}

struct BrakeLock {
};
consteval auto row_of(const BrakeLock*)
{
    return message<BrakeLock, Acknowledged>({.name = "brake-lock",
                                             .opcode = 0x78,
                                             .access = Access::command,
                                             .moves = true,
                                             .manual = "RMD-X V3.6",
                                             .says = "Engage the holding brake."},
                                            bare_side<BrakeLock>(), acknowledged());
}

struct SystemReset {
};
consteval auto row_of(const SystemReset*)
{
    return message<SystemReset, Nothing>({.name = "system-reset",
                                          .opcode = 0x76,
                                          .access = Access::command,
                                          .moves = true,
                                          .manual = "RMD-X V3.6",
                                          .says = "Start the drive again; it takes about a second and sends nothing."},
                                         bare_side<SystemReset>(), no_side);
}

} // namespace myactuator

} // namespace sinew::rmd
