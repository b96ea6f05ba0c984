#pragma once
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

/// The two robots that random programs drive.
namespace sinew::robot::test {

inline constexpr std::string_view robot_text = R"(
version = 1
[bus.s]
family = "sam"
[bus.n]
family = "nuri"
bit_rate = 115200
[bus.r]
family = "rmd"
[safety]
policy = "hold"
command_timeout_s = 0.4
stop_time_s = 0.15
[joint.shoulder]
bus = "s"
id = 1
model = "SAM-160EO200"
direction = -1
position_min_deg = -60
position_max_deg = 90
velocity_max_deg_s = 120
[joint.shoulder.profile_options]
response_level = 1
[joint.wrist]
bus = "s"
id = 2
model = "SAM-20"
position_min_deg = -50
position_max_deg = 70
velocity_max_deg_s = 200
step_max_deg = 20
[joint.waist]
bus = "n"
id = 1
ratio = 2
position_min_deg = -45
position_max_deg = 45
velocity_max_deg_s = 60
[joint.knee]
bus = "r"
id = 1
model = "MG"
profile = "rmd-2.35"
direction = -1
zero_deg = 150
position_min_deg = -10
position_max_deg = 120
velocity_max_deg_s = 180
current_max_a = 2
[joint.knee.sim]
start_rad = 2.6
[joint.ankle]
bus = "r"
id = 2
model = "MG"
profile = "lk-2.35"
ratio = 1.5
zero_deg = 180
position_min_deg = -80
position_max_deg = 80
velocity_max_deg_s = 240
current_max_a = 1
[joint.ankle.sim]
start_rad = 3.1
)";

/// The demo robot, all its 16 joints. Its RMD stand in the middle of their first turn, so that a motor that has started
/// afresh knows where it is.
inline std::string demo_text()
{
    std::ifstream file("robots/demo.toml");
    std::string text((std::istreambuf_iterator<char>(file)), {});
    const auto after = [&](std::string_view line, std::string_view more) {
        for (auto at = text.find(line); at != std::string::npos; at = text.find(line, at + 1))
            text.insert(at + line.size(), more);
    };
    after("profile = \"rmd-2.35\"\n", "zero_deg = 180\ncurrent_max_a = 2\n");
    after("model = \"SAM-20\"\n", "step_max_deg = 20\n");
    for (const auto* joint : {"left_hip", "left_knee", "left_ankle", "right_hip", "right_knee", "right_ankle"})
        text += fmt::format("[joint.{}.sim]\nstart_rad = 3.1415926536\n", joint);
    return text + "[safety]\npolicy = \"hold\"\ncommand_timeout_s = 0.4\nstop_time_s = 0.15\n";
}

} // namespace sinew::robot::test
