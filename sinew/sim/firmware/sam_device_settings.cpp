#include "sinew/sim/firmware/sam_device.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {

// ---- gains: flash values change those in use as well (A.9) ----

Handled<sam::SetPdGain> SamDevice::handle(const sam::SetPdGain& m)
{
    for (SamGains* gains : {&stored_.used.gains, &registers_.gains}) {
        gains->p = m.p_gain;
        gains->d = m.d_gain;
    }
    return sam::PdGain{m.p_gain, m.d_gain};
}

Handled<sam::SetRuntimePdGain> SamDevice::handle(const sam::SetRuntimePdGain& m)
{
    registers_.gains.p = m.p_gain;
    registers_.gains.d = m.d_gain;
    return sam::PdGain{m.p_gain, m.d_gain};
}

Handled<sam::QuickSetRuntimePdGain> SamDevice::handle(const sam::QuickSetRuntimePdGain& m)
{
    return handle(sam::SetRuntimePdGain{m.p_gain, m.d_gain});
}

Handled<sam::ReadPdGain> SamDevice::handle(const sam::ReadPdGain&)
{
    return sam::PdGain{registers_.gains.p, registers_.gains.d};
}

Handled<sam::SetIGain> SamDevice::handle(const sam::SetIGain& m)
{
    stored_.used.gains.i = m.i_gain;
    registers_.gains.i = m.i_gain;
    return sam::IGain{m.i_gain};
}

Handled<sam::SetRuntimeIGain> SamDevice::handle(const sam::SetRuntimeIGain& m)
{
    constexpr int strict_most = 10; // L2240
    if (spec_.profile.i_gain_strict && m.i_gain > strict_most)
        return {};
    registers_.gains.i = m.i_gain;
    return sam::IGain{m.i_gain};
}

Handled<sam::ReadIGain> SamDevice::handle(const sam::ReadIGain&)
{
    return sam::IGain{registers_.gains.i};
}

// ---- torque, current and position limits ----

Handled<sam::SetAvgTorque> SamDevice::handle(const sam::SetAvgTorque& m)
{
    stored_.used.avg_torque = std::min<std::uint16_t>(m.avg_torque, 2000); // S35
    return sam::AvgTorque{stored_.used.avg_torque};
}

Handled<sam::ReadAvgTorque> SamDevice::handle(const sam::ReadAvgTorque&)
{
    return sam::AvgTorque{stored_.used.avg_torque};
}

Handled<sam::QuickSetOverload> SamDevice::handle(const sam::QuickSetOverload& m)
{
    stored_.used.overload = static_cast<std::uint16_t>(m.overload << 4); // GUESS (S60): one register
    return sam::QuickOverload{m.overload};
}

Handled<sam::QuickReadOverload> SamDevice::handle(const sam::QuickReadOverload&)
{
    return sam::QuickOverload{static_cast<std::uint8_t>(std::min(stored_.used.overload >> 4, 254))};
}

Handled<sam::SetOverload> SamDevice::handle(const sam::SetOverload& m)
{
    stored_.used.overload = m.overload;
    return sam::Overload{m.overload};
}

Handled<sam::ReadOverload> SamDevice::handle(const sam::ReadOverload&)
{
    return sam::Overload{stored_.used.overload};
}

// S33: 0 counts as 1.
bool SamDevice::set_boundary(bool quick, int lower, int upper)
{
    lower = std::max(lower, 1);
    if (lower >= upper)
        return false;
    store_boundary(stored_.used, spec_, quick, {static_cast<std::uint8_t>(lower), static_cast<std::uint8_t>(upper)});
    return true;
}

// S32: a device takes both orders and sends back what it got.
Handled<sam::QuickSetBoundary> SamDevice::handle(const sam::QuickSetBoundary& m)
{
    if (!set_boundary(true, std::min(m.lower_boundary, m.upper_boundary), std::max(m.lower_boundary, m.upper_boundary)))
        return {};
    return sam::Boundary{.upper_boundary = m.upper_boundary, .lower_boundary = m.lower_boundary};
}

Handled<sam::QuickReadBoundary> SamDevice::handle(const sam::QuickReadBoundary&)
{
    const SamBoundary& boundary = stored_.used.quick_boundary;
    return sam::Boundary{.upper_boundary = boundary.upper, .lower_boundary = boundary.lower};
}

Handled<sam::SetBoundary> SamDevice::handle(const sam::SetBoundary& m)
{
    if (!set_boundary(false, m.lower_boundary, m.upper_boundary))
        return {};
    return handle(sam::ReadBoundary{});
}

Handled<sam::ReadBoundary> SamDevice::handle(const sam::ReadBoundary&)
{
    const SamBoundary& boundary = stored_.used.standard_boundary;
    return sam::Boundary{.upper_boundary = boundary.upper, .lower_boundary = boundary.lower};
}

// ---- the registers of the code listing (S36) ----

Handled<sam::SetCtrlSpeed> SamDevice::handle(const sam::SetCtrlSpeed& m)
{
    registers_.ctrl_speed = m.ctrl_speed;
    return sam::CtrlSpeed{m.ctrl_speed};
}

Handled<sam::ReadCtrlSpeed> SamDevice::handle(const sam::ReadCtrlSpeed&)
{
    return sam::CtrlSpeed{registers_.ctrl_speed};
}

Handled<sam::SetCtrlTorque> SamDevice::handle(const sam::SetCtrlTorque& m)
{
    registers_.ctrl_torque = m.ctrl_torque;
    return sam::CtrlTorque{m.ctrl_torque};
}

Handled<sam::ReadCtrlTorque> SamDevice::handle(const sam::ReadCtrlTorque&)
{
    return sam::CtrlTorque{registers_.ctrl_torque};
}

Handled<sam::SetCtrlAccel> SamDevice::handle(const sam::SetCtrlAccel& m)
{
    registers_.ctrl_accel = m.ctrl_accel;
    return sam::CtrlAccel{m.ctrl_accel};
}

Handled<sam::ReadCtrlAccel> SamDevice::handle(const sam::ReadCtrlAccel&)
{
    return sam::CtrlAccel{registers_.ctrl_accel};
}

Handled<sam::SetCtrlDecel> SamDevice::handle(const sam::SetCtrlDecel& m)
{
    registers_.ctrl_decel = m.ctrl_decel;
    return sam::CtrlDecel{m.ctrl_decel};
}

Handled<sam::ReadCtrlDecel> SamDevice::handle(const sam::ReadCtrlDecel&)
{
    return sam::CtrlDecel{registers_.ctrl_decel};
}

// ---- external port and motion program ----

Handled<sam::WriteExternalPort> SamDevice::handle(const sam::WriteExternalPort& m)
{
    registers_.port = {m.led_red, m.led_blue, m.do1, m.do2};
    return registers_.port;
}

Handled<sam::QuickWriteExternalPort> SamDevice::handle(const sam::QuickWriteExternalPort& m)
{
    return handle(sam::WriteExternalPort{m.led_red, m.led_blue, m.do1, m.do2});
}

sam::ExternalPort SamDevice::port() const
{
    if (!is_on())
        return {};
    sam::ExternalPort out = registers_.port;
    out.led_red |= protection_.red_led();
    out.led_blue |= protection_.blue_led();
    return out;
}

void SamDevice::set_external(double voltage_v)
{
    external_v_ = std::clamp(voltage_v, 0.0, sam::external_max_v);
}

std::uint16_t SamDevice::raw_external() const
{
    return static_cast<std::uint16_t>(std::min(std::lround(external_v_ / sam::external_v_per_ad), 4095L));
}

Handled<sam::ReadExternalAd> SamDevice::handle(const sam::ReadExternalAd&)
{
    return sam::ExternalAd{raw_external()};
}

Handled<sam::QuickReadExternalAd> SamDevice::handle(const sam::QuickReadExternalAd&)
{
    return sam::ExternalAd{raw_external()};
}

// GUESS (A.14 5): it runs at once.
Handled<sam::WriteMotionData> SamDevice::handle(const sam::WriteMotionData& m)
{
    stored_.used.motion_count = m.motion_count;
    stored_.used.motion = m.instructions;
    if (spec_.device.motion_runs_when_written)
        program_.start(stored_.used.motion, stored_.used.motion_count, spec_.device);
    return sam::MotionCount{m.motion_count};
}

Handled<sam::QuickWriteMotionData> SamDevice::handle(const sam::QuickWriteMotionData& m)
{
    return handle(sam::WriteMotionData{m.motion_count, m.instructions});
}

Handled<sam::ReadMotionData> SamDevice::handle(const sam::ReadMotionData&)
{
    return sam::MotionCount{stored_.used.motion_count};
}

Handled<sam::QuickReadMotionData> SamDevice::handle(const sam::QuickReadMotionData&)
{
    return sam::MotionCount{stored_.used.motion_count};
}

} // namespace sinew::sim
