#pragma once
#include "tests/robot/lossy_can.hpp"

namespace sinew::robot::test {

/// Something is in its way at 30 deg, where its load has a long lever.
inline const std::string blocked_knee =
    "version = 1\n[safety]\npolicy = \"hold\"\nsilence_max_s = 0.5\n[bus.r]\nfamily = \"rmd\"\n"
    "[joint.knee]\nbus = \"r\"\nid = 1\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\n"
    "velocity_max_deg_s = 60\n[joint.knee.plant]\nstop_max_deg = 30\ngravity_torque_nm = 5\n"
    "gravity_zero_deg = -60\n";

} // namespace sinew::robot::test
