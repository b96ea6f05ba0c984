#pragma once
#include "sinew/family/rmd/identifiers.hpp"
#include "sinew/wire/message.hpp"

#include <cstdint>

/// RMD: the 28 messages of the manual (V2.35). Source: rmd.txt; resolutions named in each row (README.md of this
/// folder). Bytes are the data bytes of the CAN frame; multi-byte fields are little endian.
namespace sinew::rmd {

using namespace wire;

/// The device answers 0x9B with 0x9B and not, as the manual's table prints, with 0x9A (R04). Hosts take both.
inline constexpr std::uint32_t clear_error_reply_9b = 1U << 0;

// ---- words for raw values ----

enum class Spin : std::uint8_t { clockwise, counter_clockwise };
inline constexpr Label spins[] = {{0, "clockwise"}, {1, "counterclockwise"}};

/// 4.1 (R16).
enum class ParameterId : std::uint8_t {
    angle_pid = 0x96,
    speed_pid,
    current_pid,
    max_torque_current,
    max_speed,
    max_angle_low,
    max_angle_high,
    current_ramp,
    speed_ramp,
};
inline constexpr Label parameter_ids[] = {{0x96, "angle_pid"},          {0x97, "speed_pid"},    {0x98, "current_pid"},
                                          {0x99, "max_torque_current"}, {0x9A, "max_speed"},    {0x9B, "max_angle_low"},
                                          {0x9C, "max_angle_high"},     {0x9D, "current_ramp"}, {0x9E, "speed_ramp"}};

/// Bits of the error state; the others are not explained (R31).
inline constexpr Label error_flags[] = {{1, "low voltage"}, {8, "over temperature"}};

inline constexpr Label write_results[] = {{0, "written"}, {1, "failed"}};

/// The manual's 0 … 16383 is that of a 14-bit encoder; other motors send up to 16 bit, and the model says how many.
inline constexpr std::string_view encoder_width = "as wide as the encoder of the model";

// ---- framing (L7-17, L193-201; R24) ----

inline constexpr Range ids{1, 32};

inline constexpr Field command_fields[] = {{.name = "command", .byte = 0, .kind = Kind::opcode}};

/// One motor: identifier 0x140 + id, command in the first byte, requests and replies alike.
inline constexpr Layout command_frame{
    .name = "single motor", .fields = command_fields, .can_base = identifier_base, .ids = ids};
/// Motors 1 to 4 at once; no command byte.
inline constexpr Layout multi_motor{.name = "multi motor", .can_base = multi_motor_identifier, .can_fixed = true};

// ---- the nine parameters of 0x40, 0x42 and 0x44, in data bytes 2 to 7 (4.1) ----

consteval Field parameter(std::string_view name, int byte, int bytes, Coding coding, std::string_view unit = {})
{
    return {.name = name,
            .byte = static_cast<std::uint8_t>(byte),
            .bytes = static_cast<std::uint8_t>(bytes),
            .coding = coding,
            .unit = unit};
}

inline constexpr Field pid_fields[] = {parameter("kp", 2, 2, Coding::u_le), parameter("ki", 4, 2, Coding::u_le),
                                       parameter("kd", 6, 2, Coding::u_le)};
inline constexpr Field max_torque_current_fields[] = {parameter("max_torque_current", 2, 2, Coding::i_le)};
inline constexpr Field max_speed_fields[] = {parameter("max_speed", 2, 4, Coding::i_le)};
inline constexpr Field max_angle_low_fields[] = {parameter("max_angle_bytes_0_3", 2, 4, Coding::u_le)};
inline constexpr Field max_angle_high_fields[] = {parameter("max_angle_bytes_4_7", 2, 4, Coding::u_le)};
inline constexpr Field current_ramp_fields[] = {parameter("current_ramp", 2, 2, Coding::i_le)};
inline constexpr Field speed_ramp_fields[] = {parameter("speed_ramp", 2, 4, Coding::i_le)};

/// Units, signs and defaults are not printed (R17).
inline constexpr Variant parameters[] = {
    {0x96, "angle_pid", pid_fields},
    {0x97, "speed_pid", pid_fields},
    {0x98, "current_pid", pid_fields},
    {0x99, "max_torque_current", max_torque_current_fields},
    {0x9A, "max_speed", max_speed_fields},
    {0x9B, "max_angle_low", max_angle_low_fields},
    {0x9C, "max_angle_high", max_angle_high_fields},
    {0x9D, "current_ramp", current_ramp_fields},
    {0x9E, "speed_ramp", speed_ramp_fields},
};

/// A side whose `value` is one of the parameters.
template <class S>
consteval S with_parameters(S s)
{
    s.selector = "param_id";
    s.replaced = "value";
    s.variants = parameters;
    return s;
}

/// A side that is nothing but its command.
template <class S>
consteval auto bare_side()
{
    return side<S>(command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
                   reserved("null_4", 4), reserved("null_5", 5), reserved("null_6", 6), reserved("null_7", 7));
}

// ---- answers that several messages share ----

struct MotorState {
    std::int8_t temperature{};
    std::int16_t iq{};
    std::int16_t speed{};
    std::uint16_t encoder{};
};
consteval auto motor_state()
{
    return side<MotorState>(
        command_frame, 8, i8(&MotorState::temperature, {.name = "temperature", .byte = 1, .unit = "degC"}),
        i16_le(&MotorState::iq, {.name = "iq", .byte = 2, .range = {-2048, 2048}, .unit = "A", .scale = by_model}),
        i16_le(&MotorState::speed, {.name = "speed", .byte = 4, .unit = "dps"}),
        u16_le(&MotorState::encoder, {.name = "encoder", .byte = 6, .says = encoder_width}));
}

struct Acknowledged {
};
consteval auto acknowledged()
{
    return bare_side<Acknowledged>();
}

struct Status1 {
    std::int8_t temperature{};
    std::uint16_t voltage{};
    std::uint8_t error_state{};
};
consteval auto status1()
{
    return side<Status1>(
        command_frame, 8, i8(&Status1::temperature, {.name = "temperature", .byte = 1, .unit = "degC"}),
        reserved("null_2", 2), u16_le(&Status1::voltage, {.name = "voltage", .byte = 3, .unit = "V", .scale = 0.1}),
        reserved("null_5", 5), reserved("null_6", 6),
        u8(&Status1::error_state, {.name = "error_state",
                                   .byte = 7,
                                   .labels = error_flags,
                                   .says = "bit 0 low voltage, bit 3 over temperature; other bits are not explained"}));
}

struct ParameterResult {
    std::uint8_t param_id_echo{};
    std::uint8_t result{};
};
consteval auto parameter_result()
{
    return side<ParameterResult>(
        command_frame, 8, u8(&ParameterResult::param_id_echo, {.name = "param_id_echo", .byte = 1}),
        u8(&ParameterResult::result, {.name = "result", .byte = 2, .range = {0, 1}, .labels = write_results}),
        reserved("null_3", 3), reserved("null_4", 4), reserved("null_5", 5), reserved("null_6", 6),
        reserved("null_7", 7));
}

struct Acceleration {
    std::int32_t acceleration{};
};
consteval auto acceleration()
{
    return side<Acceleration>(
        command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
        i32_le(&Acceleration::acceleration, {.name = "acceleration", .byte = 4, .unit = "dps/s"}));
}

struct ReadParameter {
    ParameterId param_id{};
};
struct ParameterValue {
    ParameterId param_id{};
    std::uint64_t value{};
};
consteval auto row_of(const ReadParameter*)
{
    return message<ReadParameter, ParameterValue>(
        {.name = "read-parameter",
         .opcode = 0x40,
         .manual = "4.1",
         .errata = "R16 R17",
         .says = "Read one of the nine parameters."},
        side<ReadParameter>(
            command_frame, 8,
            u8(&ReadParameter::param_id, {.name = "param_id", .byte = 1, .range = {150, 158}, .labels = parameter_ids}),
            reserved("null_2", 2), reserved("null_3", 3), reserved("null_4", 4), reserved("null_5", 5),
            reserved("null_6", 6), reserved("null_7", 7)),
        with_parameters(
            side<ParameterValue>(command_frame, 8,
                                 u8(&ParameterValue::param_id,
                                    {.name = "param_id", .byte = 1, .range = {150, 158}, .labels = parameter_ids}),
                                 u48_le(&ParameterValue::value, {.name = "value", .byte = 2}))));
}

struct WriteParameterRam {
    ParameterId param_id{};
    std::uint64_t value{};
};
consteval auto row_of(const WriteParameterRam*)
{
    return message<WriteParameterRam, ParameterResult>(
        {.name = "write-parameter-ram",
         .opcode = 0x42,
         .access = Access::command,
         .manual = "4.2",
         .errata = "R17 R18",
         .says = "Set one of the nine parameters until power-off."},
        with_parameters(
            side<WriteParameterRam>(command_frame, 8,
                                    u8(&WriteParameterRam::param_id,
                                       {.name = "param_id", .byte = 1, .range = {150, 158}, .labels = parameter_ids}),
                                    u48_le(&WriteParameterRam::value, {.name = "value", .byte = 2}))),
        parameter_result());
}

struct WriteParameterRom {
    ParameterId param_id{};
    std::uint64_t value{};
};
consteval auto row_of(const WriteParameterRom*)
{
    return message<WriteParameterRom, ParameterResult>(
        {.name = "write-parameter-rom",
         .opcode = 0x44,
         .access = Access::flash,
         .manual = "4.3",
         .errata = "R17 R18",
         .says = "Store one of the nine parameters."},
        with_parameters(
            side<WriteParameterRom>(command_frame, 8,
                                    u8(&WriteParameterRom::param_id,
                                       {.name = "param_id", .byte = 1, .range = {150, 158}, .labels = parameter_ids}),
                                    u48_le(&WriteParameterRom::value, {.name = "value", .byte = 2}))),
        parameter_result());
}

struct ReadAcceleration {
};
consteval auto row_of(const ReadAcceleration*)
{
    return message<ReadAcceleration, Acceleration>({.name = "read-acceleration",
                                                    .opcode = 0x33,
                                                    .manual = "none (4.4 is missing); list 2 entry 4",
                                                    .errata = "R05 R06",
                                                    .says = "Read the acceleration limit."},
                                                   bare_side<ReadAcceleration>(), acceleration());
}

struct WriteAccelerationRam {
    std::int32_t acceleration{};
};
consteval auto row_of(const WriteAccelerationRam*)
{
    return message<WriteAccelerationRam, Acceleration>(
        {.name = "write-acceleration-ram",
         .opcode = 0x34,
         .access = Access::command,
         .manual = "4.5",
         .errata = "R06 R20",
         .says = "Set the acceleration limit until power-off."},
        side<WriteAccelerationRam>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i32_le(&WriteAccelerationRam::acceleration, {.name = "acceleration", .byte = 4, .unit = "dps/s"})),
        acceleration());
}

struct ReadEncoder {
};
struct Encoder {
    std::uint16_t encoder{};
    std::uint16_t encoder_raw{};
    std::uint16_t encoder_offset{};
};
consteval auto row_of(const ReadEncoder*)
{
    return message<ReadEncoder, Encoder>(
        {.name = "read-encoder",
         .opcode = 0x90,
         .manual = "4.6",
         .says = "Read the encoder position, its raw value and the offset between them."},
        bare_side<ReadEncoder>(),
        side<Encoder>(command_frame, 8, reserved("null_1", 1),
                      u16_le(&Encoder::encoder, {.name = "encoder", .byte = 2, .says = encoder_width}),
                      u16_le(&Encoder::encoder_raw, {.name = "encoder_raw", .byte = 4, .says = encoder_width}),
                      u16_le(&Encoder::encoder_offset, {.name = "encoder_offset", .byte = 6, .says = encoder_width})));
}

struct WriteEncoderOffset {
    std::uint16_t encoder_offset{};
};
struct EncoderOffset {
    std::uint16_t encoder_offset{};
};
consteval auto row_of(const WriteEncoderOffset*)
{
    return message<WriteEncoderOffset, EncoderOffset>(
        {.name = "write-encoder-offset",
         .opcode = 0x91,
         .access = Access::flash,
         .moves = true,
         .manual = "4.7",
         .errata = "R07 R08",
         .says = "Store the encoder offset."},
        side<WriteEncoderOffset>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            reserved("null_4", 4), reserved("null_5", 5),
            u16_le(&WriteEncoderOffset::encoder_offset, {.name = "encoder_offset", .byte = 6, .says = encoder_width})),
        side<EncoderOffset>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            reserved("null_4", 4), reserved("null_5", 5),
            u16_le(&EncoderOffset::encoder_offset, {.name = "encoder_offset", .byte = 6, .says = encoder_width})));
}

struct WriteCurrentPositionZeroRom {
};
consteval auto row_of(const WriteCurrentPositionZeroRom*)
{
    return message<WriteCurrentPositionZeroRom, EncoderOffset>(
        {.name = "write-current-position-zero-rom",
         .opcode = 0x19,
         .access = Access::flash,
         .moves = true,
         .manual = "4.8",
         .errata = "R38",
         .says = "Store the present position as zero; it counts after the next power-on."},
        bare_side<WriteCurrentPositionZeroRom>(),
        side<EncoderOffset>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            reserved("null_4", 4), reserved("null_5", 5),
            u16_le(&EncoderOffset::encoder_offset, {.name = "encoder_offset", .byte = 6, .says = encoder_width})));
}

struct ReadMultiTurnAngle {
};
struct MultiTurnAngle {
    std::int64_t angle{};
};
consteval auto row_of(const ReadMultiTurnAngle*)
{
    return message<ReadMultiTurnAngle, MultiTurnAngle>(
        {.name = "read-multi-turn-angle",
         .opcode = 0x92,
         .manual = "4.9",
         .errata = "R10",
         .says = "Read the angle over all turns; positive is clockwise."},
        bare_side<ReadMultiTurnAngle>(),
        side<MultiTurnAngle>(
            command_frame, 8,
            i56_le(&MultiTurnAngle::angle, {.name = "angle", .byte = 1, .unit = "deg", .scale = 0.01})));
}

struct ReadSingleTurnAngle {
};
struct SingleTurnAngle {
    std::uint16_t circle_angle{};
};
consteval auto row_of(const ReadSingleTurnAngle*)
{
    return message<ReadSingleTurnAngle, SingleTurnAngle>(
        {.name = "read-single-turn-angle",
         .opcode = 0x94,
         .manual = "4.10",
         .errata = "R32",
         .says = "Read the angle inside one turn."},
        bare_side<ReadSingleTurnAngle>(),
        side<SingleTurnAngle>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            reserved("null_4", 4), reserved("null_5", 5),
            u16_le(&SingleTurnAngle::circle_angle,
                   {.name = "circle_angle", .byte = 6, .range = {0, 35999}, .unit = "deg", .scale = 0.01})));
}

struct SetCurrentPositionZero {
};
consteval auto row_of(const SetCurrentPositionZero*)
{
    return message<SetCurrentPositionZero, Acknowledged>({.name = "set-current-position-zero",
                                                          .opcode = 0x95,
                                                          .access = Access::command,
                                                          .moves = true,
                                                          .manual = "4.11",
                                                          .errata = "R09",
                                                          .says = "Make the present position zero until power-off."},
                                                         bare_side<SetCurrentPositionZero>(), acknowledged());
}

struct ReadStatus1 {
};
consteval auto row_of(const ReadStatus1*)
{
    return message<ReadStatus1, Status1>({.name = "read-status1",
                                          .opcode = 0x9A,
                                          .manual = "4.12",
                                          .errata = "R31",
                                          .says = "Read temperature, voltage and error flags."},
                                         bare_side<ReadStatus1>(), status1());
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
                                         .manual = "4.13",
                                         .errata = "R04 R31",
                                         .says = "Clear the error flags whose cause is gone."},
                                        bare_side<ClearError>(), status1());
}

struct ReadStatus2 {
};
consteval auto row_of(const ReadStatus2*)
{
    return message<ReadStatus2, MotorState>({.name = "read-status2",
                                             .opcode = 0x9C,
                                             .manual = "4.14",
                                             .errata = "R11 R23",
                                             .says = "Read temperature, torque current, speed and encoder."},
                                            bare_side<ReadStatus2>(), motor_state());
}

struct ReadStatus3 {
};
struct PhaseCurrents {
    std::int16_t phase_a_current{};
    std::int16_t phase_b_current{};
    std::int16_t phase_c_current{};
};
consteval auto row_of(const ReadStatus3*)
{
    return message<ReadStatus3, PhaseCurrents>(
        {.name = "read-status3",
         .opcode = 0x9D,
         .manual = "4.15",
         .errata = "R33",
         .says = "Read the three phase currents."},
        bare_side<ReadStatus3>(),
        side<PhaseCurrents>(command_frame, 8, reserved("null_1", 1),
                            i16_le(&PhaseCurrents::phase_a_current,
                                   {.name = "phase_a_current", .byte = 2, .unit = "A", .scale = 0.015625}),
                            i16_le(&PhaseCurrents::phase_b_current,
                                   {.name = "phase_b_current", .byte = 4, .unit = "A", .scale = 0.015625}),
                            i16_le(&PhaseCurrents::phase_c_current,
                                   {.name = "phase_c_current", .byte = 6, .unit = "A", .scale = 0.015625})));
}

struct MotorOff {
};
consteval auto row_of(const MotorOff*)
{
    return message<MotorOff, Acknowledged>({.name = "motor-off",
                                            .opcode = 0x80,
                                            .access = Access::command,
                                            .moves = true,
                                            .manual = "4.16",
                                            .errata = "R30",
                                            .says = "Switch the motor off and forget what it was doing."},
                                           bare_side<MotorOff>(), acknowledged());
}

struct MotorStop {
};
consteval auto row_of(const MotorStop*)
{
    return message<MotorStop, Acknowledged>({.name = "motor-stop",
                                             .opcode = 0x81,
                                             .access = Access::command,
                                             .moves = true,
                                             .manual = "4.17",
                                             .errata = "R30",
                                             .says = "Stop the motor but remember what it was doing."},
                                            bare_side<MotorStop>(), acknowledged());
}

struct MotorRunning {
};
consteval auto row_of(const MotorRunning*)
{
    return message<MotorRunning, Acknowledged>({.name = "motor-running",
                                                .opcode = 0x88,
                                                .access = Access::command,
                                                .moves = true,
                                                .manual = "4.18",
                                                .errata = "R30",
                                                .says = "Go on after a stop."},
                                               bare_side<MotorRunning>(), acknowledged());
}

struct TorqueOpenLoop {
    std::int16_t power{};
};
struct OpenLoopState {
    std::int8_t temperature{};
    std::int16_t power{};
    std::int16_t speed{};
    std::uint16_t encoder{};
};
consteval auto row_of(const TorqueOpenLoop*)
{
    return message<TorqueOpenLoop, OpenLoopState>(
        {.name = "torque-open-loop",
         .opcode = 0xA0,
         .access = Access::command,
         .moves = true,
         .manual = "5.1",
         .errata = "R06 R21",
         .says = "Drive with a given power, without any limit."},
        side<TorqueOpenLoop>(command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
                             i16_le(&TorqueOpenLoop::power, {.name = "power", .byte = 4, .range = {-850, 850}}),
                             reserved("null_6", 6), reserved("null_7", 7)),
        side<OpenLoopState>(command_frame, 8,
                            i8(&OpenLoopState::temperature, {.name = "temperature", .byte = 1, .unit = "degC"}),
                            i16_le(&OpenLoopState::power, {.name = "power", .byte = 2, .range = {-850, 850}}),
                            i16_le(&OpenLoopState::speed, {.name = "speed", .byte = 4, .unit = "dps"}),
                            u16_le(&OpenLoopState::encoder, {.name = "encoder", .byte = 6, .says = encoder_width})));
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
         .manual = "5.2",
         .errata = "R11 R12 R22",
         .says = "Drive with a given torque current, not limited by the maximum torque current."},
        side<TorqueClosedLoop>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i16_le(&TorqueClosedLoop::iq,
                   {.name = "iq", .byte = 4, .range = {-2048, 2048}, .unit = "A", .scale = by_model}),
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
         .manual = "5.3",
         .errata = "R03 R11",
         .says = "Turn at a given speed."},
        side<SpeedClosedLoop>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i32_le(&SpeedClosedLoop::speed, {.name = "speed", .byte = 4, .unit = "dps", .scale = 0.01})),
        motor_state());
}

struct MultiLoopAngle {
    std::int32_t angle{};
};
consteval auto row_of(const MultiLoopAngle*)
{
    return message<MultiLoopAngle, MotorState>(
        {.name = "multi-loop-angle",
         .opcode = 0xA3,
         .access = Access::command,
         .moves = true,
         .manual = "5.4",
         .errata = "R02 R11",
         .says = "Go to an angle over all turns."},
        side<MultiLoopAngle>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i32_le(&MultiLoopAngle::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
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
         .manual = "part 1 (20); 5.5",
         .errata = "R01 R02 R11",
         .says = "Go to an angle over all turns at a given speed at most."},
        side<MultiLoopAngleSpeed>(
            command_frame, 8, reserved("null_1", 1),
            u16_le(&MultiLoopAngleSpeed::max_speed, {.name = "max_speed", .byte = 2, .unit = "dps", .scale = 0.01}),
            i32_le(&MultiLoopAngleSpeed::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
        motor_state());
}

struct SingleLoopAngle {
    Spin spin_direction{};
    std::uint16_t angle{};
};
consteval auto row_of(const SingleLoopAngle*)
{
    return message<SingleLoopAngle, MotorState>(
        {.name = "single-loop-angle",
         .opcode = 0xA5,
         .access = Access::command,
         .moves = true,
         .manual = "5.6",
         .errata = "R11 R28 R37",
         .says = "Go to an angle inside one turn in a given direction."},
        side<SingleLoopAngle>(command_frame, 8,
                              u8(&SingleLoopAngle::spin_direction,
                                 {.name = "spin_direction", .byte = 1, .range = {0, 1}, .labels = spins}),
                              reserved("null_2", 2), reserved("null_3", 3),
                              u16_le(&SingleLoopAngle::angle,
                                     {.name = "angle", .byte = 4, .range = {0, 35999}, .unit = "deg", .scale = 0.01}),
                              reserved("null_6", 6), reserved("null_7", 7)),
        motor_state());
}

struct SingleLoopAngleSpeed {
    Spin spin_direction{};
    std::uint16_t max_speed{};
    std::uint16_t angle{};
};
consteval auto row_of(const SingleLoopAngleSpeed*)
{
    return message<SingleLoopAngleSpeed, MotorState>(
        {.name = "single-loop-angle-speed",
         .opcode = 0xA6,
         .access = Access::command,
         .moves = true,
         .manual = "5.7",
         .errata = "R01 R11 R28",
         .says = "Go to an angle inside one turn in a given direction, at a given speed at most."},
        side<SingleLoopAngleSpeed>(
            command_frame, 8,
            u8(&SingleLoopAngleSpeed::spin_direction,
               {.name = "spin_direction", .byte = 1, .range = {0, 1}, .labels = spins}),
            u16_le(&SingleLoopAngleSpeed::max_speed, {.name = "max_speed", .byte = 2, .unit = "dps", .scale = 0.01}),
            u16_le(&SingleLoopAngleSpeed::angle,
                   {.name = "angle", .byte = 4, .range = {0, 35999}, .unit = "deg", .scale = 0.01}),
            reserved("null_6", 6), reserved("null_7", 7)),
        motor_state());
}

struct IncrementAngle {
    std::int32_t angle{};
};
consteval auto row_of(const IncrementAngle*)
{
    return message<IncrementAngle, MotorState>(
        {.name = "increment-angle",
         .opcode = 0xA7,
         .access = Access::command,
         .moves = true,
         .relative = true,
         .manual = "5.8",
         .errata = "R11 R29",
         .says = "Turn on by an angle."},
        side<IncrementAngle>(
            command_frame, 8, reserved("null_1", 1), reserved("null_2", 2), reserved("null_3", 3),
            i32_le(&IncrementAngle::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
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
         .manual = "5.9",
         .errata = "R01 R11 R29",
         .says = "Turn on by an angle at a given speed at most."},
        side<IncrementAngleSpeed>(
            command_frame, 8, reserved("null_1", 1),
            u16_le(&IncrementAngleSpeed::max_speed, {.name = "max_speed", .byte = 2, .unit = "dps", .scale = 0.01}),
            i32_le(&IncrementAngleSpeed::angle, {.name = "angle", .byte = 4, .unit = "deg", .scale = 0.01})),
        motor_state());
}

struct MultiMotorTorque {
    std::int16_t iq_1{};
    std::int16_t iq_2{};
    std::int16_t iq_3{};
    std::int16_t iq_4{};
};
consteval auto row_of(const MultiMotorTorque*)
{
    return message<MultiMotorTorque, MotorState>(
        {.name = "multi-motor-torque",
         .reply_opcode = 0xA1,
         .access = Access::command,
         .moves = true,
         .broadcast = true,
         .manual = "6.1 / 6.2",
         .errata = "R11 R12 R25",
         .says = "Give the motors 1 to 4 a torque current each in one frame."},
        side<MultiMotorTorque>(
            multi_motor, 8,
            i16_le(&MultiMotorTorque::iq_1,
                   {.name = "iq_1", .byte = 0, .range = {-2000, 2000}, .unit = "A", .scale = 0.016}),
            i16_le(&MultiMotorTorque::iq_2,
                   {.name = "iq_2", .byte = 2, .range = {-2000, 2000}, .unit = "A", .scale = 0.016}),
            i16_le(&MultiMotorTorque::iq_3,
                   {.name = "iq_3", .byte = 4, .range = {-2000, 2000}, .unit = "A", .scale = 0.016}),
            i16_le(&MultiMotorTorque::iq_4,
                   {.name = "iq_4", .byte = 6, .range = {-2000, 2000}, .unit = "A", .scale = 0.016})),
        motor_state());
}

/// Every message of the manual.
using ManualMessages =
    MessageList<ReadParameter, WriteParameterRam, WriteParameterRom, ReadAcceleration, WriteAccelerationRam,
                ReadEncoder, WriteEncoderOffset, WriteCurrentPositionZeroRom, ReadMultiTurnAngle, ReadSingleTurnAngle,
                SetCurrentPositionZero, ReadStatus1, ClearError, ReadStatus2, ReadStatus3, MotorOff, MotorStop,
                MotorRunning, TorqueOpenLoop, TorqueClosedLoop, SpeedClosedLoop, MultiLoopAngle, MultiLoopAngleSpeed,
                SingleLoopAngle, SingleLoopAngleSpeed, IncrementAngle, IncrementAngleSpeed, MultiMotorTorque>;
inline constexpr auto manual_messages = catalogue(ManualMessages{});

} // namespace sinew::rmd
