#include "sinew/config/robot_file.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

namespace sinew::config {
namespace {

constexpr std::string_view arm = R"(version = 1
name = "arm"
[bus.right]
family = "rmd"
link = "can:can0"
[bus.left]
family = "sam"
bit_rate = 1500000
[joint.wrist]
bus = "left"
id = 7
[joint.elbow]
bus = "right"
id = 2
model = "MF"
profile = "lk-2.35"
direction = -1
zero_deg = 90
ratio = 2.5
position_min_deg = -45
position_max_rad = 1
velocity_max_deg_s = 180
[joint.elbow.profile_options]
max_speed_lsb_dps = 1
off_requires_run = true
[joint.elbow.sim]
increment_base = "position"
supply_v = 23.5
)";

/// What is said about a text as the file "r.toml".
std::string complaint(std::string_view text)
{
    const auto file = parse_robot_file(text, "r.toml");
    if (file)
        return "nothing";
    EXPECT_EQ(file.error().code, Errc::bad_file);
    return file.error().detail;
}

std::string with_joint(std::string_view lines)
{
    return "version = 1\n[bus.left]\nfamily = \"sam\"\n[joint.elbow]\nbus = \"left\"\nid = 3\n" + std::string{lines};
}

TEST(RobotFile, HasWhatTheRobotHoldsItsJointsTo)
{
    const auto file = parse_robot_file(R"(version = 1
[safety]
policy = "brake"
on_fault = "joint"
command_timeout_s = 0.25
step_max_deg = 90
silence_max_s = 1
[bus.left]
family = "sam"
rate_hz = 500
[bus.left.realtime]
lock_memory = true
priority = 80
processor = 1
[joint.elbow]
bus = "left"
id = 3
current_max_a = 1.5
torque_max_nm = 4
temperature_max_c = 60
stop_time_s = 0.2
[joint.elbow.home]
routine = "stop"
direction = 1
position_deg = 180
velocity_rad_s = 0.5
travel_max_deg = 90
)",
                                       "r.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    EXPECT_EQ(file->safety.policy, Policy::brake);
    EXPECT_FALSE(file->safety.whole_robot);
    EXPECT_EQ(file->safety.command_timeout_s, 0.25);
    EXPECT_NEAR(*file->safety.step_max_rad, std::numbers::pi / 2, 1e-12);
    EXPECT_EQ(file->safety.silence_max_s, 1.0);
    EXPECT_EQ(file->safety.stop_time_s, 0.1) << "the default";
    const Bus& bus = file->buses[0];
    EXPECT_EQ(bus.rate_hz, 500.0);
    EXPECT_TRUE(bus.realtime.lock_memory);
    EXPECT_EQ(bus.realtime.priority->value, 80);
    EXPECT_EQ(bus.realtime.processor->value, 1);
    const Joint& joint = file->joints[0];
    EXPECT_EQ(joint.current_max_a, 1.5);
    EXPECT_EQ(joint.torque_max_nm, 4.0);
    EXPECT_EQ(joint.temperature_max_c, 60.0);
    EXPECT_EQ(joint.stop_time_s, 0.2);
    EXPECT_TRUE(joint.home.to_stop);
    EXPECT_EQ(joint.home.direction, 1);
    EXPECT_NEAR(joint.home.position_rad, std::numbers::pi, 1e-12);
    EXPECT_NEAR(*joint.home.travel_max_rad, std::numbers::pi / 2, 1e-12);
}

TEST(RobotFile, RefusesSafetyThatMakesNoSense)
{
    const auto safety = [](std::string_view line) { return complaint("version = 1\n[safety]\n" + std::string{line}); };
    EXPECT_EQ(safety("policy = \"drop\""), "r.toml:3:10: policy must be one of hold, release, brake.");
    EXPECT_EQ(safety("command_timeout_s = 0"), "r.toml:3:21: command_timeout_s must be above 0.");
    EXPECT_EQ(safety("step_max_deg = -1"), "r.toml:3:16: step_max_deg must be above 0.");
    EXPECT_EQ(safety("polcy = \"hold\""), "r.toml:3:1: safety has no key 'polcy', did you mean policy?");
    EXPECT_EQ(complaint(with_joint("current_max_a = 0")), "r.toml:7:17: current_max_a must be above 0.");
    EXPECT_EQ(complaint("version = 1\n[bus.left]\nfamily = \"sam\"\nrate_hz = 0"),
              "r.toml:4:11: rate_hz must be above 0.");
    EXPECT_EQ(complaint("version = 1\n[bus.left]\nfamily = \"sam\"\n[bus.left.realtime]\npriority = 100"),
              "r.toml:5:12: priority must be from 1 to 99.");
    EXPECT_EQ(complaint("version = 1\n[bus.left]\nfamily = \"sam\"\n[bus.left.realtime]\nlock_memory = 1"),
              "r.toml:5:15: lock_memory must be true or false, not a whole number.");
    EXPECT_EQ(complaint("version = 2\n"), "r.toml:1:11: version 2 is not known; this sinew reads version 1.");
}

TEST(RobotFile, KeepsTheOrderOfTheFile)
{
    const auto file = parse_robot_file(arm, "arm.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    EXPECT_EQ(file->name, "arm");
    ASSERT_EQ(file->buses.size(), 2U);
    EXPECT_EQ(file->buses[0].name, "right");
    EXPECT_EQ(file->buses[1].name, "left");
    ASSERT_EQ(file->joints.size(), 2U);
    EXPECT_EQ(file->joints[0].name, "wrist");
    EXPECT_EQ(file->joints[1].name, "elbow");
}

TEST(RobotFile, ReadsEveryKeyOfAJointAndTurnsDegreesIntoRadians)
{
    const auto file = parse_robot_file(arm, "arm.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    const Joint& elbow = *file->find_joint("elbow");
    EXPECT_EQ(elbow.bus.value, "right");
    EXPECT_EQ(elbow.id.value, 2);
    EXPECT_EQ(elbow.id.at.line, 14U);
    EXPECT_EQ(elbow.id.at.column, 6U);
    EXPECT_EQ(elbow.model->value, "MF");
    EXPECT_EQ(elbow.profile->value, "lk-2.35");
    EXPECT_EQ(elbow.direction, -1);
    EXPECT_DOUBLE_EQ(elbow.zero_rad, std::numbers::pi / 2);
    EXPECT_DOUBLE_EQ(elbow.ratio, 2.5);
    EXPECT_DOUBLE_EQ(*elbow.position_min_rad, -std::numbers::pi / 4);
    EXPECT_DOUBLE_EQ(*elbow.position_max_rad, 1.0);
    EXPECT_DOUBLE_EQ(*elbow.velocity_max_rad_s, std::numbers::pi);
    ASSERT_EQ(elbow.options.size(), 2U);
    EXPECT_EQ(elbow.options[0].key, "max_speed_lsb_dps");
    EXPECT_EQ(std::get<std::int64_t>(elbow.options[0].value), 1);
    EXPECT_EQ(std::get<bool>(elbow.options[1].value), true);
    ASSERT_EQ(elbow.sim.size(), 2U);
    EXPECT_EQ(std::get<std::string>(elbow.sim[0].value), "position");
    EXPECT_EQ(std::get<double>(elbow.sim[1].value), 23.5);
    EXPECT_EQ(file->find_bus("right")->link->value, "can:can0");
    EXPECT_EQ(file->find_bus("left")->bit_rate->value, 1'500'000);
}

TEST(RobotFile, AJointWithoutOptionalKeysHasPlainDefaults)
{
    const auto file = parse_robot_file(with_joint(""), "r.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    const Joint& elbow = file->joints.front();
    EXPECT_FALSE(elbow.model || elbow.profile || elbow.position_min_rad || elbow.velocity_max_rad_s);
    EXPECT_EQ(elbow.direction, 1);
    EXPECT_EQ(elbow.ratio, 1.0);
}

TEST(RobotFile, AnUnknownKeyIsReportedWithLineAndColumnAndTheNearestOne)
{
    EXPECT_EQ(complaint(with_joint("  modle = \"SAM-5\"\n")),
              "r.toml:7:3: joint elbow has no key 'modle', did you mean model?");
    EXPECT_EQ(complaint("version = 1\nnmae = \"x\"\n"),
              "r.toml:2:1: a robot file has no key 'nmae', did you mean name?");
    EXPECT_EQ(complaint("version = 1\n[bus.left]\nfamily = \"sam\"\nbitrate = 9600\n"),
              "r.toml:4:1: bus left has no key 'bitrate', did you mean bit_rate?");
    EXPECT_EQ(complaint(with_joint("backlash_rad = 1\n")), "r.toml:7:1: joint elbow has no key 'backlash_rad'.");
}

TEST(RobotFile, TheFirstOfTwoUnknownKeysInTheFileIsReported)
{
    EXPECT_EQ(complaint(with_joint("zzzz = 1\naaaa = 2\n")), "r.toml:7:1: joint elbow has no key 'zzzz'.");
}

TEST(RobotFile, AWrongTypeIsReportedWhereTheValueStands)
{
    EXPECT_EQ(complaint("version = 1\n[bus.left]\nfamily = 5\n"),
              "r.toml:3:10: family must be a text in quotes, not a whole number.");
    EXPECT_EQ(complaint("version = 1\n[bus.left]\nfamily = \"sam\"\n[joint.a]\nbus = \"left\"\nid = 1.5\n"),
              "r.toml:6:6: id must be a whole number, not a number.");
    EXPECT_EQ(complaint(with_joint("ratio = \"2\"\n")), "r.toml:7:9: ratio must be a number, not a text.");
    EXPECT_EQ(complaint(with_joint("sim = 3\n")), "r.toml:7:1: sim must be a table, not a whole number.");
    EXPECT_EQ(complaint(with_joint("sim.x = [1]\n")),
              "r.toml:7:5: x must be a number, a text or true or false, not a list.");
    EXPECT_EQ(complaint("version = 1\nbus.left = 1\n"), "r.toml:2:5: left must be a table: [bus.NAME].");
}

TEST(RobotFile, TheVersionMustBeOne)
{
    EXPECT_EQ(complaint("name = \"x\"\n"), "r.toml:1:1: a robot file needs version = 1.");
    EXPECT_EQ(complaint("version = 2\nnew_key = 1\n"),
              "r.toml:1:11: version 2 is not known; this sinew reads version 1.");
}

TEST(RobotFile, WhatABusAndAJointNeedIsAskedFor)
{
    EXPECT_EQ(complaint("version = 1\n[bus.left]\n"), "r.toml:2:6: bus left needs family.");
    EXPECT_EQ(complaint("version = 1\n[joint.elbow]\nid = 1\n"), "r.toml:2:8: joint elbow needs bus.");
    EXPECT_EQ(complaint("version = 1\n[joint.elbow]\nbus = \"left\"\n"), "r.toml:2:8: joint elbow needs id.");
}

TEST(RobotFile, ABusThatIsNotThereSuggestsTheNearest)
{
    EXPECT_EQ(complaint("version = 1\n[bus.left]\nfamily = \"sam\"\n[joint.a]\nbus = \"letf\"\nid = 1\n"),
              "r.toml:5:7: there is no bus 'letf', did you mean left?");
}

TEST(RobotFile, TwoBusesWithTheSameLinkAreReported)
{
    const auto with = [](std::string_view second) {
        return "version = 1\n[bus.left]\nfamily = \"sam\"\nlink = \"serial:/dev/pts/3?baud=1500000\"\n"
               "[bus.two]\nfamily = \"sam\"\nlink = \"" +
               std::string(second) + "\"\n";
    };
    EXPECT_EQ(complaint(with("serial:/dev/pts/3?baud=9600")),
              "r.toml:7:8: buses left and two have the same link; a link carries one bus.");
    EXPECT_EQ(complaint(with("serial:/dev/pts/30")), "nothing");
    EXPECT_EQ(complaint("version = 1\n[bus.a]\nfamily = \"sam\"\nlink = \"sim:a.toml#a\"\n"
                        "[bus.b]\nfamily = \"sam\"\nlink = \"sim:a.toml#b\"\n"),
              "nothing");
}

TEST(RobotFile, NumbersThatMakeNoSenseAreRefused)
{
    EXPECT_EQ(complaint(with_joint("zero_rad = nan\n")), "r.toml:7:12: zero_rad must be a finite number.");
    EXPECT_EQ(complaint(with_joint("velocity_max_rad_s = inf\n")),
              "r.toml:7:22: velocity_max_rad_s must be a finite number.");
    EXPECT_EQ(complaint(with_joint("velocity_max_rad_s = 0\n")), "r.toml:7:22: the greatest velocity must be above 0.");
    EXPECT_EQ(complaint(with_joint("direction = 0\n")), "r.toml:7:13: direction must be 1 or -1.");
    EXPECT_EQ(complaint(with_joint("ratio = -1\n")),
              "r.toml:7:9: ratio must be above 0; use direction = -1 to turn the joint round.");
    EXPECT_EQ(complaint("version = 1\n[bus.left]\nfamily = \"sam\"\nbit_rate = 0\n"),
              "r.toml:4:12: bit_rate must be above 0.");
}

TEST(RobotFile, TheLowestPositionMustBeBelowTheHighest)
{
    EXPECT_EQ(complaint(with_joint("position_min_deg = 10\nposition_max_deg = 10\n")),
              "r.toml:7:20: the lowest position must be below the highest.");
    EXPECT_EQ(complaint(with_joint("position_min_deg = 9\nposition_max_deg = 10\n")), "nothing");
}

TEST(RobotFile, RadiansAndDegreesOfOneThingAreNotGivenTogether)
{
    EXPECT_EQ(complaint(with_joint("zero_rad = 1\nzero_deg = 10\n")),
              "r.toml:8:12: zero_rad is given already; keep zero_rad or zero_deg.");
}

TEST(RobotFile, NamesAreWhatALinkCanCarry)
{
    EXPECT_EQ(complaint("version = 1\n[bus.\"a#b\"]\nfamily = \"sam\"\n"),
              "r.toml:2:6: the name 'a#b' may only have letters, digits, - and _.");
}

TEST(RobotFile, ABrokenFileIsReportedWhereItBreaks)
{
    const std::string said = complaint("version = 1\nname = \n");
    EXPECT_EQ(said.substr(0, 9), "r.toml:2:") << said;
}

TEST(RobotFile, AJointThatIsThereTwiceIsReported)
{
    const std::string said = complaint(with_joint("[joint.elbow]\nbus = \"left\"\nid = 4\n"));
    EXPECT_EQ(said.substr(0, 9), "r.toml:7:") << said;
}

TEST(RobotFile, AFileThatIsNotThereOrAFolderIsSaidSo)
{
    EXPECT_EQ(read_robot_file("no/such/robot.toml").error().detail, "no/such/robot.toml: there is no such file.");
    EXPECT_EQ(read_robot_file(".").error().detail, ".: this is a folder, not a robot file.");
    EXPECT_EQ(read_robot_file(".").error().code, Errc::bad_file);
}

TEST(RobotFile, IsReadFromDiskWithItsPathInEveryMessage)
{
    const std::string path = testing::TempDir() + "sinew_robot_file_test.toml";
    std::ofstream{path} << "version = 3\n";
    EXPECT_EQ(read_robot_file(path).error().detail,
              path + ":1:11: version 3 is not known; this sinew reads version 1.");
    std::ofstream{path} << arm;
    EXPECT_EQ(read_robot_file(path)->joints.size(), 2U);
}

} // namespace
} // namespace sinew::config
