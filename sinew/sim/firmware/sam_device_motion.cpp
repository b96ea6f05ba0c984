#include "sinew/sim/firmware/sam_device.hpp"

#include <algorithm>

namespace sinew::sim {
namespace {

constexpr int weakest_level = 4;  // L392
constexpr int fastest_quick = 15; // L412

// L412: 1 is 15 % and 15 is 50 %; GUESS (S42): a line between, or the parabola through what the option says of 8.
double quick_duty(int speed, double middle_duty)
{
    constexpr double middle = 8.0;
    const double bend = (speed - middle) / 7.0;
    return speed == 0 ? 0.0 : 0.125 + 0.025 * speed + (middle_duty - 0.325) * (1.0 - bend * bend);
}

// Clockwise is positive (L726-728).
double signed_duty(int wheel_speed)
{
    return wheel_speed < 1000 ? wheel_speed / 1000.0 : (1000 - wheel_speed) / 1000.0;
}

// GUESS (S84): "resolution 400 times" of 2000.
int torque_of_level(int level)
{
    return (5 - level) * 400;
}

} // namespace

// ---- commands that move; they suspend the program (GUESS, A.14 5) until power-on or another program ----

std::uint8_t SamDevice::quick_position() const
{
    return static_cast<std::uint8_t>(motion_.raw_position(spec_.model->quick));
}

Handled<sam::QuickPositionControl> SamDevice::handle(const sam::QuickPositionControl& m)
{
    const sam::QuickState before{motion_.raw_quick_load(), quick_position()};
    program_.stop();
    quick_go_to(m.torque_level, m.target_position);
    return before;
}

void SamDevice::quick_go_to(int torque_level, int target)
{
    const int torque = std::min<int>(torque_of_level(torque_level), stored_.used.avg_torque);
    motion_.go_to(target, spec_.model->quick, stored_.used.quick_boundary, spec_.model->quick.deg_per_unit, torque,
                  registers_);
}

void SamDevice::quick_wheel(double duty)
{
    motion_.wheel(duty, stored_.used.quick_boundary, spec_.model->quick.deg_per_unit);
}

Handled<sam::PositionControl> SamDevice::handle(const sam::PositionControl& m)
{
    const sam::Position before{static_cast<std::uint16_t>(motion_.raw_position(spec_.model->standard))};
    program_.stop();
    motion_.go_to(m.target_position, spec_.model->standard, stored_.used.standard_boundary,
                  spec_.model->boundary_deg_per_unit, stored_.used.avg_torque, registers_);
    return before;
}

Handled<sam::PrecisePositionControl> SamDevice::handle(const sam::PrecisePositionControl& m)
{
    const sam::PrecisePosition before{static_cast<std::uint32_t>(motion_.raw_position(*spec_.model->precise))};
    program_.stop();
    motion_.go_to(m.target_position, *spec_.model->precise, stored_.used.standard_boundary,
                  spec_.model->boundary_deg_per_unit, stored_.used.avg_torque, registers_);
    return before;
}

Handled<sam::QuickPassiveMode> SamDevice::handle(const sam::QuickPassiveMode&)
{
    program_.stop();
    motion_.passive();
    return sam::Identity{raw_id()};
}

Handled<sam::QuickWheelMode> SamDevice::handle(const sam::QuickWheelMode& m)
{
    const sam::QuickTurns before = spec_.profile.wheel_reply == sam::WheelReply::id_id
                                       ? sam::QuickTurns{raw_id(), raw_id()}
                                       : sam::QuickTurns{motion_.turns(), quick_position()};
    program_.stop();
    const double duty = quick_duty(m.speed, spec_.device.wheel_middle_duty);
    quick_wheel(m.direction == sam::QuickSpin::clockwise ? duty : -duty);
    return before;
}

Handled<sam::QuickBrakeMode> SamDevice::handle(const sam::QuickBrakeMode&)
{
    const sam::QuickBrakeState before{raw_id(), quick_position()};
    program_.stop();
    motion_.brake();
    return before;
}

Handled<sam::SpecialControl> SamDevice::handle(const sam::SpecialControl& m)
{
    program_.stop();
    switch (m.mode) {
    case sam::Mode::position:
        motion_.hold();
        break;
    case sam::Mode::passive:
        motion_.passive();
        break;
    case sam::Mode::brake:
        motion_.brake();
        break;
    case sam::Mode::wheel:
        motion_.wheel(signed_duty(m.wheel_speed), stored_.used.standard_boundary, spec_.model->boundary_deg_per_unit);
        break;
    }
    return sam::ControlMode{raw_id(), m.mode};
}

Handled<sam::OffsetControl> SamDevice::handle(const sam::OffsetControl& m)
{
    if (spec_.device.offset_control_works)
        motion_.offset(m.offset_control == 1);
    return sam::Offset{m.offset_control};
}

// ---- the program of its own ----

void SamDevice::run_program()
{
    if (!program_.is_running())
        return;
    program_.tick_begins();
    const SamProgram::Senses senses{.position = quick_position(), .ad = raw_external() >> 4};
    while (const auto action = program_.next(senses))
        perform(*action);
}

void SamDevice::perform(const SamProgram::Action& action)
{
    switch (action.instruction) {
    case SamProgram::Instruction::position:
        quick_go_to(std::min<int>(action.sub, weakest_level), action.data);
        break;
    case SamProgram::Instruction::outputs: // GUESS (S64f): the first output is bit 0
        registers_.port.do1 = (action.data & 1) != 0;
        registers_.port.do2 = (action.data & 2) != 0;
        break;
    case SamProgram::Instruction::special: {
        const double duty = quick_duty(std::min<int>(action.data, fastest_quick), spec_.device.wheel_middle_duty);
        if (action.sub == 1)
            motion_.passive();
        else if (action.sub == 2)
            motion_.brake();
        else if (action.sub == static_cast<int>(sam::QuickSpin::counter_clockwise))
            quick_wheel(-duty);
        else if (action.sub == static_cast<int>(sam::QuickSpin::clockwise))
            quick_wheel(duty);
        break;
    }
    default:
        break;
    }
}

// ---- read-outs ----

Handled<sam::QuickReadStatus> SamDevice::handle(const sam::QuickReadStatus&)
{
    return sam::QuickState{motion_.raw_quick_load(), quick_position()};
}

Handled<sam::ReadCurrentSpeed> SamDevice::handle(const sam::ReadCurrentSpeed&)
{
    return sam::CurrentSpeed{motion_.raw_speed()};
}

Handled<sam::ReadCurrentAccel> SamDevice::handle(const sam::ReadCurrentAccel&)
{
    return sam::CurrentAccel{motion_.raw_acceleration()};
}

Handled<sam::ReadCurrentLoad> SamDevice::handle(const sam::ReadCurrentLoad&)
{
    return sam::CurrentLoad{motion_.raw_load()};
}

Handled<sam::ReadCurrentPosition> SamDevice::handle(const sam::ReadCurrentPosition&)
{
    return sam::Position{static_cast<std::uint16_t>(motion_.raw_position(spec_.model->standard))};
}

Handled<sam::ReadPrecisePosition> SamDevice::handle(const sam::ReadPrecisePosition&)
{
    return sam::PrecisePosition{static_cast<std::uint32_t>(motion_.raw_position(*spec_.model->precise))};
}

Handled<sam::ReadInputVoltage> SamDevice::handle(const sam::ReadInputVoltage&)
{
    return sam::InputVoltage{motion_.raw_voltage(supply_v())};
}

Handled<sam::ReadTemperatureError> SamDevice::handle(const sam::ReadTemperatureError&)
{
    return sam::TemperatureError{std::uint8_t{protection_.is_hot()}};
}

} // namespace sinew::sim
