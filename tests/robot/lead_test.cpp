#include "sinew/robot/play.hpp"

#include "sinew/family/sam/messages.hpp"
#include "sinew/family/sam/models.hpp"
#include "sinew/robot/pose.hpp"
#include "sinew/wire/codec.hpp"
#include "tests/robot/rig.hpp"

#include <algorithm>
#include <gtest/gtest.h>

/// A SAM that is led step by step against what blocks it, and what it does when that gives way.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

constexpr Duration for_ever = 20s; ///< of a motion that is planned to take less than one

config::RobotFile led(std::string_view model, double velocity_deg_s, std::string_view plant)
{
    return file_of(fmt::format("version = 1\n[bus.b]\nfamily = \"sam\"\n[joint.joint]\nbus = \"b\"\nmodel = \"{}\"\n"
                               "id = 3\nvelocity_max_deg_s = {}\n[joint.joint.plant]\n{}\n[pose.up]\njoint_deg = 60\n",
                               model, velocity_deg_s, plant));
}

void set_overload(Rig& rig, double above_a)
{
    const auto raw = static_cast<std::uint16_t>(above_a / sam::find_model("SAM-160EO200")->current_a_per_ad12);
    const auto told = wire::encode_request<sam::SetOverload>(3, {.overload = std::min<std::uint16_t>(raw, 4095)});
    ASSERT_TRUE(told);
    (void)rig.simulator->world().find_device("joint")->hear(*told, rig.now());
}

struct Ended {
    std::string said;
    Duration took{};
};

Ended play_up(Rig& rig)
{
    const TimePoint begun = rig.now();
    PlayOptions options;
    options.stop_asked = [&] {
        if (rig.now() - begun > for_ever)
            rig.robot->request_stop();
        return false;
    };
    const auto played = play(*rig.robot, sequence_of(*rig.robot->file().find_pose("up")), options);
    return {played ? "" : to_sentence(played.error()), rig.now() - begun};
}

/// By a robot that walks there.
Ended walk_up(Rig& rig, double velocity_deg_s)
{
    const TimePoint begun = rig.now();
    Joint& joint = *rig.robot->find("joint");
    EXPECT_TRUE(joint.set(
        {.mode = Mode::position, .position_rad = units::rad(60), .velocity_rad_s = units::rad(velocity_deg_s)}));
    while (rig.now() - begun < for_ever && joint.command().mode == Mode::position)
        EXPECT_TRUE(rig.run(10ms));
    return {joint.overruled_by() != nullptr ? to_sentence(*joint.overruled_by()) : "", rig.now() - begun};
}

/// Above a current it lets go after 0.2 s, for 0.3 s: its load falls by some degrees, and it comes back.
struct LetsGo {
    double above_a, velocity_deg_s;
    std::string_view load;
};
constexpr LetsGo falls_from_its_lead[] = {
    {4.095, 120, "gravity_torque_nm = 2\ngravity_zero_deg = -60"}, // as delivered; blocked, it takes 5 A
    {4.095, 120, "external_torque_nm = -2"},
    {0.94, 163, "external_torque_nm = -4.2"}, // before it has come to its lead
};

TEST(Lead, AMotionAgainstAStopEndsAlsoWhereTheServoLetsItsLoadFallAgainAndAgain)
{
    for (const LetsGo& servo : falls_from_its_lead)
        for (const bool by_play : {true, false}) {
            Rig rig(led("SAM-160EO200", servo.velocity_deg_s, fmt::format("stop_max_deg = 30\n{}", servo.load)));
            rig.enable();
            set_overload(rig, servo.above_a);
            const Ended ended = by_play ? play_up(rig) : walk_up(rig, servo.velocity_deg_s);
            EXPECT_NE(ended.said.find("does not follow"), std::string::npos) << servo.load << ended.said;
            EXPECT_LT(ended.took, 4s) << servo.load;
        }
}

} // namespace
} // namespace sinew::robot::test
