#pragma once
#include "sinew/family/rmd/messages.hpp"

/// RMD: the messages whose layout differs on another firmware line. A message keeps the name it has in the manual where
/// it is the same thing. Sources: the vendor documents and drivers listed in README.md; what they leave unclear is not
/// here, and so a profile refuses it.
namespace sinew::rmd {

/// A request that is nothing but its command.
template <class M>
consteval auto bare_request()
{
    return side<M>(command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
                   reserved("null_4", 4), reserved("null_5", 5), reserved("null_6", 6), reserved("null_7", 7));
}

// ---- LK-Tech V2.35 (2024-02) and V2.36 (2024-11) ----

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
                                         bare_request<ReadStatus1>(), two_flags());
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
                                        bare_request<ClearError>(), two_flags());
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
        bare_request<ReadStatus3>(),
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
        bare_request<ReadSingleTurnAngle>(),
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
                                             bare_request<ReadStatus1>(), lk::eight_flags());
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
                                            bare_request<ClearError>(), lk::eight_flags());
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

// ---- GYEMS V1.62 ----

namespace gyems {

struct Pid {
    std::uint8_t angle_kp{}, angle_ki{}, speed_kp{}, speed_ki{}, current_kp{}, current_ki{};
};
template <class M>
consteval auto pid_side()
{
    return side<M>(command_frame, 8, reserved("null_1", 1), u8(&M::angle_kp, {.name = "angle_kp", .byte = 2}),
                   u8(&M::angle_ki, {.name = "angle_ki", .byte = 3}), u8(&M::speed_kp, {.name = "speed_kp", .byte = 4}),
                   u8(&M::speed_ki, {.name = "speed_ki", .byte = 5}),
                   u8(&M::current_kp, {.name = "current_kp", .byte = 6}),
                   u8(&M::current_ki, {.name = "current_ki", .byte = 7}));
}

struct ReadPid {
};
consteval auto row_of(const ReadPid*)
{
    return message<ReadPid, Pid>({.name = "read-pid",
                                  .opcode = 0x30,
                                  .manual = "GYEMS V1.61",
                                  .says = "Read the gains of the angle, speed and current loops."},
                                 bare_request<ReadPid>(), pid_side<Pid>());
}

struct WritePidRam {
    std::uint8_t angle_kp{}, angle_ki{}, speed_kp{}, speed_ki{}, current_kp{}, current_ki{};
};
consteval auto row_of(const WritePidRam*)
{
    return message<WritePidRam, Pid>({.name = "write-pid-ram",
                                      .opcode = 0x31,
                                      .access = Access::command,
                                      .manual = "GYEMS V1.61",
                                      .says = "Set the gains of the three loops until power-off."},
                                     pid_side<WritePidRam>(), pid_side<Pid>());
}

struct WritePidRom {
    std::uint8_t angle_kp{}, angle_ki{}, speed_kp{}, speed_ki{}, current_kp{}, current_ki{};
};
consteval auto row_of(const WritePidRom*)
{
    return message<WritePidRom, Pid>({.name = "write-pid-rom",
                                      .opcode = 0x32,
                                      .access = Access::flash,
                                      .manual = "GYEMS V1.61",
                                      .says = "Store the gains of the three loops."},
                                     pid_side<WritePidRom>(), pid_side<Pid>());
}

/// Commands are ±2000 for ±32 A while replies are ±2048 for ±33 A, so the two fields have names of their own.
struct TorqueClosedLoop {
    std::int16_t iq_control{};
};
consteval auto row_of(const TorqueClosedLoop*)
{
    return message<TorqueClosedLoop, MotorState>(
        {.name = "torque-closed-loop",
         .opcode = 0xA1,
         .access = Access::command,
         .moves = true,
         .manual = "GYEMS V1.62",
         .errata = "R11 R12",
         .says = "Drive with a given torque current."},
        side<TorqueClosedLoop>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i16_le(&TorqueClosedLoop::iq_control,
                   {.name = "iq_control", .byte = 4, .range = {-2000, 2000}, .unit = "A", .scale = 0.016}),
            reserved("null_6", 6), reserved("null_7", 7)),
        motor_state());
}

} // namespace gyems

// ---- MyActuator RMD-X V3.6 to V4.2 ----

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
        bare_request<ReadStatus1>(),
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
                                            bare_request<ReadStatus2>(), motor_state());
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
        bare_request<ReadStatus3>(),
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
        bare_request<ReadMultiTurnAngle>(),
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
                                               bare_request<BrakeRelease>(), acknowledged());
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
                                            bare_request<BrakeLock>(), acknowledged());
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
                                         bare_request<SystemReset>(), no_side);
}

} // namespace myactuator

// ---- what exists on each line ----

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
