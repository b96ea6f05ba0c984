#pragma once
#include "sinew/sim/fault.hpp"
#include "tests/robot/rig.hpp"

namespace sinew::robot::test {

inline const char* const servo_by_hand =
    "version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\nmodel = \"SAM-20\"\n";

inline void wait(sim::Simulator& simulator, Duration time)
{
    const TimePoint until = simulator.clock().now() + time;
    while (simulator.clock().now() < until) // what arrives meanwhile ends a wait
        simulator.clock().wait({}, until);
}

/// A program that asks its user to guide the arm by hand, and waits for a key.
inline void guide_by_hand(sim::Simulator& simulator, Duration pause, double torque_nm)
{
    sim::Fault push{.kind = sim::FaultKind::push, .joint = "arm", .for_s = seconds(pause) / 2};
    push.torque_nm = torque_nm;
    simulator.world().inject(push);
    wait(simulator, pause);
}

} // namespace sinew::robot::test
