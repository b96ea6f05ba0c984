#pragma once
#include "sinew/config/robot_file.hpp"
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <string_view>
#include <vector>

/// What the tests of this room share: a robot with three buses, and requests written down by hand from the manuals.
namespace sinew::sim::test {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

inline constexpr std::string_view robot_text = R"(version = 1
name = "three"

[bus.left]
family = "sam"
bit_rate = 1500000

[bus.waist]
family = "nuri"
bit_rate = 115200

[bus.legs]
family = "rmd"
bit_rate = 1000000

[joint.shoulder]
bus = "left"
id = 0
model = "SAM-210EO200"

[joint.elbow]
bus = "left"
id = 3
model = "SAM-210EO200"

[joint.twist]
bus = "waist"
id = 1

[joint.bend]
bus = "waist"
id = 2

[joint.hip]
bus = "legs"
id = 1

[joint.knee]
bus = "legs"
id = 2
)";

inline config::RobotFile robot()
{
    const auto file = config::parse_robot_file(robot_text, "three.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    return *file;
}

/// Quick read status (A-1-1): position and load in two bytes.
inline const Bytes sam_status_0{0xFF, 0xA0, 0x00, 0x20};
inline const Bytes sam_status_3{0xFF, 0xA3, 0x00, 0x23};

/// Feedback request 0xA0, answered by ping feedback 0xD0.
inline const Bytes nuri_ping_1{0xFF, 0xFE, 0x01, 0x02, 0x5C, 0xA0};
inline const Bytes nuri_pong_1{0xFF, 0xFE, 0x01, 0x02, 0x2C, 0xD0};
inline const Bytes nuri_ping_2{0xFF, 0xFE, 0x02, 0x02, 0x5B, 0xA0};
inline const Bytes nuri_pong_2{0xFF, 0xFE, 0x02, 0x02, 0x2B, 0xD0};

/// Read motor state 2.
inline wire::Frame rmd_state(std::uint32_t id)
{
    return {.can_id = 0x140 + id, .size = 8, .data = {0x9C}};
}

inline link::ByteLink& bytes_of(link::AnyLink& link)
{
    return *std::get<std::unique_ptr<link::ByteLink>>(link);
}
inline link::CanLink& frames_of(link::AnyLink& link)
{
    return *std::get<std::unique_ptr<link::CanLink>>(link);
}

} // namespace sinew::sim::test
