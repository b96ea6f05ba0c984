#pragma once
#include "sinew/family/rmd/messages.hpp"

/// The messages whose layout differs on GYEMS V1.62.
namespace sinew::rmd {

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
                                 bare_side<ReadPid>(), pid_side<Pid>());
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

} // namespace sinew::rmd
