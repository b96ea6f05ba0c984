#pragma once
#include "sinew/family/rmd/messages.hpp"

/// The messages whose layout differs on LK-Tech V2.35 (2024-02) and V2.36 (2024-11).
namespace sinew::rmd {

namespace lk {

inline constexpr Label motor_states[] = {{0x00, "on"}, {0x10, "off"}};
/// V2.36 only.
inline constexpr Label eight_error_flags[] = {{1, "low voltage"},
                                              {2, "high voltage"},
                                              {4, "driver over temperature"},
                                              {8, "motor over temperature"},
                                              {16, "over-current"},
                                              {32, "short circuit"},
                                              {64, "stall"},
                                              {128, "input lost"}};

struct Status1 {
    std::int8_t temperature{};
    std::int16_t voltage{};
    std::int16_t bus_current{};
    std::uint8_t motor_state{};
    std::uint8_t error_state{};
};
consteval auto status1(std::span<const Label> flags, std::string_view says)
{
    return side<Status1>(command_frame, 8,
                         i8(&Status1::temperature, {.name = "temperature", .byte = 1, .unit = "degC"}),
                         i16_le(&Status1::voltage, {.name = "voltage", .byte = 2, .unit = "V", .scale = 0.01}),
                         i16_le(&Status1::bus_current, {.name = "bus_current", .byte = 4, .unit = "A", .scale = 0.01}),
                         u8(&Status1::motor_state, {.name = "motor_state", .byte = 6, .labels = motor_states}),
                         u8(&Status1::error_state, {.name = "error_state", .byte = 7, .labels = flags, .says = says}));
}
consteval auto two_flags()
{
    return status1(error_flags, "bit 0 low voltage, bit 3 over temperature; other bits are not explained");
}
consteval auto eight_flags()
{
    return status1(eight_error_flags, "one bit per fault");
}

struct ReadStatus1 {
};
consteval auto row_of(const ReadStatus1*)
{
    return message<ReadStatus1, Status1>({.name = "read-status1",
                                          .opcode = 0x9A,
                                          .manual = "LK V2.35",
                                          .errata = "R31",
                                          .says = "Read temperature, voltage, bus current, whether the motor is on, "
                                                  "and error flags."},
                                         bare_side<ReadStatus1>(), two_flags());
}

struct ClearError {
};
consteval auto row_of(const ClearError*)
{
    return message<ClearError, Status1>({.name = "clear-error",
                                         .opcode = 0x9B,
                                         .reply_opcode = 0x9A,
                                         .reply_opcode_also = 0x9B,
                                         .also_when = clear_error_reply_9b,
                                         .access = Access::command,
                                         .manual = "LK V2.35",
                                         .errata = "R04 R31",
                                         .says = "Clear the error flags whose cause is gone."},
                                        bare_side<ClearError>(), two_flags());
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
         .manual = "LK V2.35",
         .errata = "R33",
         .says = "Read temperature and the three phase currents; no effect on MS motors."},
        bare_side<ReadStatus3>(),
        side<PhaseCurrents>(command_frame, 8,
                            i8(&PhaseCurrents::temperature, {.name = "temperature", .byte = 1, .unit = "degC"}),
                            i16_le(&PhaseCurrents::phase_a_current,
                                   {.name = "phase_a_current", .byte = 2, .unit = "A", .scale = by_model}),
                            i16_le(&PhaseCurrents::phase_b_current,
                                   {.name = "phase_b_current", .byte = 4, .unit = "A", .scale = by_model}),
                            i16_le(&PhaseCurrents::phase_c_current,
                                   {.name = "phase_c_current", .byte = 6, .unit = "A", .scale = by_model})));
}

struct ReadSingleTurnAngle {
};
struct SingleTurnAngle {
    std::uint32_t circle_angle{};
};
consteval auto row_of(const ReadSingleTurnAngle*)
{
    return message<ReadSingleTurnAngle, SingleTurnAngle>(
        {.name = "read-single-turn-angle",
         .opcode = 0x94,
         .manual = "LK V2.35",
         .errata = "R32",
         .says = "Read the angle inside one turn of the output."},
        bare_side<ReadSingleTurnAngle>(),
        side<SingleTurnAngle>(command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
                              u32_le(&SingleTurnAngle::circle_angle, {.name = "circle_angle",
                                                                      .byte = 4,
                                                                      .unit = "deg",
                                                                      .scale = 0.01,
                                                                      .says = "up to 360 deg times the gear ratio"})));
}

struct SetCurrentAngle {
    std::int32_t angle{};
};
consteval auto row_of(const SetCurrentAngle*)
{
    return message<SetCurrentAngle, Acknowledged>(
        {.name = "set-current-angle",
         .opcode = 0x95,
         .access = Access::command,
         .moves = true,
         .manual = "LK V2.35",
         .says = "Call the present position an angle over all turns, until power-off."},
        side<SetCurrentAngle>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i32_le(&SetCurrentAngle::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
        acknowledged());
}

struct BrakeControl {
    std::uint8_t brake{};
};
struct BrakeState {
    std::uint8_t brake{};
};
/// The reply carries the state in the same byte.
inline constexpr Label brake_words[] = {{0x00, "engage"}, {0x01, "release"}, {0x10, "read"}};
inline constexpr Label brake_states[] = {{0x00, "engaged"}, {0x01, "released"}};
consteval auto row_of(const BrakeControl*)
{
    return message<BrakeControl, BrakeState>(
        {.name = "brake-control",
         .opcode = 0x8C,
         .access = Access::command,
         .moves = true,
         .manual = "LK V2.35",
         .says = "Engage or release the holding brake, or read its state."},
        side<BrakeControl>(
            command_frame, 8,
            u8(&BrakeControl::brake, {.name = "brake", .byte = 1, .range = {0, 0x10}, .labels = brake_words}),
            reserved("null_2", 2), reserved("null_3", 3), reserved("null_4", 4), reserved("null_5", 5),
            reserved("null_6", 6), reserved("null_7", 7)),
        side<BrakeState>(command_frame, 8, u8(&BrakeState::brake, {.name = "brake", .byte = 1, .labels = brake_states}),
                         reserved("null_2", 2), reserved("null_3", 3), reserved("null_4", 4), reserved("null_5", 5),
                         reserved("null_6", 6), reserved("null_7", 7)));
}

struct SpeedClosedLoopTorque {
    std::int16_t iq{};
    std::int32_t speed{};
};
consteval auto row_of(const SpeedClosedLoopTorque*)
{
    return message<SpeedClosedLoopTorque, MotorState>(
        {.name = "speed-closed-loop-torque",
         .opcode = 0xAD,
         .access = Access::command,
         .moves = true,
         .manual = "LK V2.35",
         .errata = "R11",
         .says = "Turn at a given speed with a given torque current at most; some motors ignore the limit."},
        side<SpeedClosedLoopTorque>(
            command_frame, 8, reserved("null_1", 1),
            i16_le(&SpeedClosedLoopTorque::iq,
                   {.name = "iq", .byte = 2, .range = {-2048, 2048}, .unit = "A", .scale = by_model}),
            i32_le(&SpeedClosedLoopTorque::speed, {.name = "speed", .byte = 4, .unit = "dps", .scale = 0.01})),
        motor_state());
}

struct SingleLoopAngle {
    Spin spin_direction{};
    std::uint32_t angle{};
};
consteval auto row_of(const SingleLoopAngle*)
{
    return message<SingleLoopAngle, MotorState>(
        {.name = "single-loop-angle",
         .opcode = 0xA5,
         .access = Access::command,
         .moves = true,
         .manual = "LK V2.35",
         .errata = "R11 R28",
         .says = "Go to an angle inside one turn in a given direction."},
        side<SingleLoopAngle>(
            command_frame, 8,
            u8(&SingleLoopAngle::spin_direction,
               {.name = "spin_direction", .byte = 1, .range = {0, 1}, .labels = spins}),
            reserved("null_2", 2), reserved("null_3", 3),
            u32_le(&SingleLoopAngle::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
        motor_state());
}

struct SingleLoopAngleSpeed {
    Spin spin_direction{};
    std::uint16_t max_speed{};
    std::uint32_t angle{};
};
consteval auto row_of(const SingleLoopAngleSpeed*)
{
    return message<SingleLoopAngleSpeed, MotorState>(
        {.name = "single-loop-angle-speed",
         .opcode = 0xA6,
         .access = Access::command,
         .moves = true,
         .manual = "LK V2.35",
         .errata = "R01 R11 R28",
         .says = "Go to an angle inside one turn in a given direction, at a given speed at most."},
        side<SingleLoopAngleSpeed>(
            command_frame, 8,
            u8(&SingleLoopAngleSpeed::spin_direction,
               {.name = "spin_direction", .byte = 1, .range = {0, 1}, .labels = spins}),
            u16_le(&SingleLoopAngleSpeed::max_speed, {.name = "max_speed", .byte = 2, .unit = "dps"}),
            u32_le(&SingleLoopAngleSpeed::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
        motor_state());
}

} // namespace lk

namespace lk_2_36 {

struct ReadStatus1 {
};
consteval auto row_of(const ReadStatus1*)
{
    return message<ReadStatus1, lk::Status1>({.name = "read-status1",
                                              .opcode = 0x9A,
                                              .manual = "LK V2.36",
                                              .says = "Read temperature, voltage, bus current, whether the motor is "
                                                      "on, and error flags."},
                                             bare_side<ReadStatus1>(), lk::eight_flags());
}

struct ClearError {
};
consteval auto row_of(const ClearError*)
{
    return message<ClearError, lk::Status1>({.name = "clear-error",
                                             .opcode = 0x9B,
                                             .reply_opcode = 0x9A,
                                             .reply_opcode_also = 0x9B,
                                             .also_when = clear_error_reply_9b,
                                             .access = Access::command,
                                             .manual = "LK V2.36",
                                             .errata = "R04",
                                             .says = "Clear the error flags whose cause is gone."},
                                            bare_side<ClearError>(), lk::eight_flags());
}

/// With a torque current of 0, as the manual's layout would send it, the motor has no torque to turn with.
struct SpeedClosedLoop {
    std::int16_t iq{};
    std::int32_t speed{};
};
consteval auto row_of(const SpeedClosedLoop*)
{
    return message<SpeedClosedLoop, MotorState>(
        {.name = "speed-closed-loop",
         .opcode = 0xA2,
         .access = Access::command,
         .moves = true,
         .manual = "LK V2.36",
         .errata = "R11",
         .says = "Turn at a given speed with a given torque current at most."},
        side<SpeedClosedLoop>(
            command_frame, 8, reserved("null_1", 1),
            i16_le(&SpeedClosedLoop::iq,
                   {.name = "iq", .byte = 2, .range = {-2048, 2048}, .unit = "A", .scale = by_model}),
            i32_le(&SpeedClosedLoop::speed, {.name = "speed", .byte = 4, .unit = "dps", .scale = 0.01})),
        motor_state());
}

} // namespace lk_2_36

} // namespace sinew::rmd
