#include "sinew/robot/play.hpp"

#include "sinew/family/sam/messages.hpp"
#include "sinew/family/sam/models.hpp"
#include "sinew/robot/pose.hpp"
#include "sinew/wire/codec.hpp"
#include "tests/robot/rig.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <utility>

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

/// What a shaft does that was stuck for 0.9 s on its way up, and came free.
struct Leap {
    double furthest_led_deg = 0.0; ///< ahead of the shaft
    double too_fast_deg = 0.0;     ///< on this way it was faster than 1.25 times what it may be
};

Leap come_free(std::string_view model, double velocity_deg_s, double load_nm)
{
    Rig rig(led(model, velocity_deg_s, fmt::format("external_torque_nm = {}", -load_nm)));
    rig.enable();
    Leap out;
    bool is_stuck = false;
    double before_deg = units::deg(rig.truth_rad("joint"));
    PlayOptions options;
    options.each = [&](const SequencePlayer&) {
        const double here_deg = units::deg(rig.truth_rad("joint")), speed_deg_s = units::deg(rig.truth_rad_s("joint"));
        if (!std::exchange(is_stuck, is_stuck || here_deg > 20.0) && is_stuck)
            rig.inject(sim::FaultKind::stuck_gear, "joint", 0.9);
        const auto& sent = rig.robot->find("joint")->command().position_rad;
        out.furthest_led_deg = std::max(out.furthest_led_deg, sent ? units::deg(*sent) - here_deg : 0.0);
        if (speed_deg_s > 1.25 * velocity_deg_s)
            out.too_fast_deg += here_deg - before_deg;
        before_deg = here_deg;
    };
    (void)play(*rig.robot, sequence_of(*rig.robot->file().find_pose("up")), options);
    EXPECT_TRUE(is_stuck);
    return out;
}

struct Loaded {
    std::string_view model;
    double load_nm;
};
/// The strongest only without a load: blocked, it takes so much that its own overload lets it fall.
constexpr Loaded servos[] = {{"SAM-160EO200", 0.0}, {"SAM-20", 0.0}, {"SAM-20", 0.5},
                             {"SAM-20", 1.0},       {"SAM-5", 0.0},  {"SAM-5", 0.25}};

TEST(Lead, AServoThatComesFreeLeapsNoFurtherThanItWasLed)
{
    for (const auto& [model, load_nm] : servos)
        for (const double velocity_deg_s : {10.0, 30.0, 60.0, 120.0}) {
            const Leap leap = come_free(model, velocity_deg_s, load_nm);
            // The formula of docs/guide/robot.md. A measurement is two periods old at most, and in steps of 0.083 deg.
            const double lead_deg = 0.12 * velocity_deg_s + 5.0 + 0.02 * velocity_deg_s + 0.083;
            EXPECT_LT(leap.furthest_led_deg, lead_deg) << model << " " << load_nm << " " << velocity_deg_s;
            EXPECT_GT(leap.furthest_led_deg, 0.12 * velocity_deg_s + 4.0) << "else it was not blocked";
            EXPECT_LT(leap.too_fast_deg, lead_deg / 2.0) << model << " " << load_nm << " " << velocity_deg_s;
        }
}

} // namespace
} // namespace sinew::robot::test
