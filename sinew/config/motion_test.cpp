#include "sinew/config/robot_file.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <numbers>

namespace sinew::config {
namespace {

constexpr std::string_view arm = R"(version = 1
[bus.left]
family = "sam"
[joint.elbow]
bus = "left"
id = 3
position_max_deg = 140
[joint.wrist]
bus = "left"
id = 4
position_min_rad = -1.5
[pose.ready]
wrist_rad = -0.5
elbow_deg = 90
)";
constexpr int lines_of_arm = 14;

std::expected<RobotFile, Error> parsed(std::string_view lines)
{
    return parse_robot_file(std::string{arm} + std::string{lines}, "r.toml");
}

/// The lines behind those of the arm count from 1 here.
std::string complaint(std::string_view lines)
{
    const auto file = parsed(lines);
    if (file)
        return "nothing";
    EXPECT_EQ(file.error().code, Errc::bad_file);
    int line = 0, column = 0, used = 0;
    if (std::sscanf(file.error().detail.c_str(), "r.toml:%d:%d: %n", &line, &column, &used) != 2)
        return file.error().detail;
    return std::to_string(line - lines_of_arm) + ":" + std::to_string(column) + ": " + file.error().detail.substr(used);
}

std::string of_step(std::string_view step)
{
    return complaint("[sequence.wave]\nsteps = [\n" + std::string{step} + ",\n]\n");
}

std::vector<Step> steps_of(std::string_view lines)
{
    const auto file = parsed("[sequence.wave]\nsteps = [\n" + std::string{lines} + "\n]\n");
    EXPECT_TRUE(file) << to_sentence(file.error());
    return file ? file->find_sequence("wave")->steps : std::vector<Step>{};
}

std::string text_of(std::string_view path)
{
    std::ifstream stream{std::filesystem::path{__FILE__}.parent_path() / "../.." / path};
    return {std::istreambuf_iterator<char>{stream}, {}};
}

TEST(Motion, TheExampleOfTheGuideStandsInTheDemoRobot)
{
    const std::string guide = text_of("docs/guide/sequences.md"), robot = text_of("robots/demo.toml");
    const auto begin = guide.find("```toml\n") + 8;
    const std::string example = guide.substr(begin, guide.find("```", begin) - begin);
    EXPECT_TRUE(parse_robot_file(robot, "demo.toml"));
    for (std::size_t at = 0; at < example.size();) { // table by table
        const auto next = std::min(example.find("\n\n[", at), example.size() - 1);
        const std::string table = example.substr(at, next + 1 - at);
        EXPECT_NE(robot.find(table), std::string::npos) << table;
        at = next + 2;
    }
}

TEST(Motion, APoseKeepsItsJointsInTheOrderOfTheFile)
{
    const auto file = parsed("");
    ASSERT_TRUE(file) << to_sentence(file.error());
    ASSERT_EQ(file->poses.size(), 1U);
    const Pose& ready = *file->find_pose("ready");
    ASSERT_EQ(ready.targets.size(), 2U);
    EXPECT_EQ(file->joints[ready.targets[0].joint].name, "wrist");
    EXPECT_DOUBLE_EQ(ready.targets[0].position_rad, -0.5);
    EXPECT_EQ(file->joints[ready.targets[1].joint].name, "elbow");
    EXPECT_DOUBLE_EQ(ready.targets[1].position_rad, std::numbers::pi / 2);
    EXPECT_EQ(ready.targets[1].at.line, 14U);
}

TEST(Motion, WhatIsWrongWithAPoseIsSaidWhereItStands)
{
    EXPECT_EQ(complaint("[pose.up]\nelbwo_deg = 9\n"), "2:1: there is no joint 'elbwo', did you mean elbow?");
    EXPECT_EQ(complaint("[pose.up]\nelbow = 9\n"),
              "2:1: 'elbow' must be a joint with its unit: JOINT_deg or JOINT_rad.");
    EXPECT_EQ(complaint("[pose.up]\nelbow_deg = 150\n"),
              "2:13: elbow at 150 deg is beyond its position_max_deg: 140 deg.");
    EXPECT_EQ(complaint("[pose.up]\nwrist_deg = -90\n"),
              "2:13: wrist at -90 deg is beyond its position_min_deg: -85.9437 deg.");
    EXPECT_EQ(complaint("[pose.up]\nelbow_deg = \"9\"\n"), "2:13: elbow_deg must be a number, not a text.");
    EXPECT_EQ(complaint("[pose.up]\nelbow_deg = nan\n"), "2:13: elbow_deg must be a finite number.");
    EXPECT_EQ(complaint("[pose.up]\nelbow_deg = 9\nelbow_rad = 1\n"),
              "3:1: elbow is given already; keep elbow_rad or elbow_deg.");
    EXPECT_EQ(complaint("[pose.up]\n"), "1:7: there is no joint in it: write JOINT_deg = ANGLE.");
}

TEST(Motion, ReadsEveryKindOfStep)
{
    const auto steps = steps_of(R"(
        {pose = "ready", duration_s = 2},
        {move = {elbow_deg = 45}, speed = 0.5, until = {joint = "elbow", current_above_a = 0.4, within_s = 3, on_timeout = "continue"}},
        {wait_s = 0.25},
        {until = {joint = "wrist", position_below_deg = 10, within_s = 1}},
        {repeat = "forever", steps = [{repeat = 3, steps = [{wait_s = 1}]}, {wait_s = 2}]},
        {call = "nod", repeat = 2}]
        [sequence.nod]
        steps = [{pose = "ready"})");
    ASSERT_EQ(steps.size(), 6U);
    EXPECT_EQ(steps[0].kind, Step::Kind::move);
    EXPECT_EQ(steps[0].name.value, "ready");
    EXPECT_EQ(steps[0].targets.size(), 2U);
    EXPECT_EQ(steps[0].duration_s, 2.0);
    EXPECT_EQ(steps[1].speed, 0.5);
    EXPECT_EQ(steps[1].until->of, Condition::Of::current);
    EXPECT_TRUE(steps[1].until->above && steps[1].until->goes_on);
    EXPECT_EQ(steps[1].until->value, 0.4);
    EXPECT_EQ(steps[1].until->within_s, 3.0);
    EXPECT_EQ(steps[2].kind, Step::Kind::wait);
    EXPECT_EQ(steps[2].duration_s, 0.25);
    EXPECT_EQ(steps[3].kind, Step::Kind::until);
    EXPECT_EQ(steps[3].until->joint, 1U);
    EXPECT_FALSE(steps[3].until->above || steps[3].until->goes_on);
    EXPECT_DOUBLE_EQ(steps[3].until->value, std::numbers::pi / 18);
    EXPECT_EQ(steps[4].kind, Step::Kind::repeat);
    EXPECT_FALSE(steps[4].times);
    EXPECT_EQ(steps[4].steps[0].times, 3);
    EXPECT_EQ(steps[5].kind, Step::Kind::call);
    EXPECT_EQ(steps[5].times, 2);
    EXPECT_EQ(steps[5].sequence, 1U);
}

TEST(Motion, WhatIsWrongWithAStepIsSaidWhereItStands)
{
    EXPECT_EQ(of_step("{pose = \"raedy\"}"), "3:9: there is no pose 'raedy', did you mean ready?");
    EXPECT_EQ(of_step("{call = \"wvae\"}"), "3:9: there is no sequence 'wvae', did you mean wave?");
    EXPECT_EQ(of_step("{}"), "3:1: a step needs one of pose, move, wait_s, until, repeat or call.");
    EXPECT_EQ(of_step("{wait = 1}"), "3:2: a step has no key 'wait', did you mean wait_s?");
    EXPECT_EQ(of_step("{pose = \"ready\", wait_s = 1}"), "3:1: a step does one thing: pose or wait_s, not both.");
    EXPECT_EQ(of_step("{wait_s = 1, speed = 1}"), "3:14: speed does not go with wait_s.");
    EXPECT_EQ(of_step("{wait_s = 0}"), "3:11: wait_s must be above 0 and no more than 1e+06.");
    EXPECT_EQ(of_step("{move = {elbow_deg = 141}}"), "3:22: elbow at 141 deg is beyond its position_max_deg: 140 deg.");
    EXPECT_EQ(of_step("{move = {}}"), "3:9: there is no joint in it: write JOINT_deg = ANGLE.");
    EXPECT_EQ(of_step("{pose = \"ready\", speed = 1.5}"),
              "3:26: speed must be above 0 and no more than 1: 0.5 is half of the fastest.");
    EXPECT_EQ(of_step("{pose = \"ready\", speed = 1, duration_s = 1}"),
              "3:26: a move has a duration or a speed, not both.");
    EXPECT_EQ(of_step("{repeat = 0, steps = [{wait_s = 1}]}"),
              "3:11: repeat must be from 1 to 1000000000, or \"forever\".");
    EXPECT_EQ(of_step("{repeat = \"always\", steps = [{wait_s = 1}]}"),
              "3:11: repeat must be a number of times or \"forever\".");
    EXPECT_EQ(of_step("{repeat = 2}"), "3:1: repeat needs steps, a list of at least one.");
    EXPECT_EQ(of_step("3"), "3:1: steps must be tables in braces, not a whole number.");
    EXPECT_EQ(complaint("[sequence.wave]\n"), "1:11: sequence wave needs steps, a list of at least one.");
    EXPECT_EQ(complaint("[sequence.wave]\nsteps = 1\n"), "2:9: steps must be a list, not a whole number.");
}

TEST(Motion, WhatIsWrongWithAConditionIsSaidWhereItStands)
{
    EXPECT_EQ(of_step("{until = {joint = \"elbow\", within_s = 1}}"),
              "3:10: until needs one thing to wait for, such as position_above_deg = 30, speed_below_deg_s = 1 or "
              "current_above_a = 0.5.");
    EXPECT_EQ(of_step("{until = {joint = \"elbow\", current_above_a = 1}}"),
              "3:10: until needs within_s: how long to wait for that.");
    EXPECT_EQ(of_step("{until = {current_above_a = 1, within_s = 1}}"), "3:10: until needs joint = \"NAME\".");
    EXPECT_EQ(of_step("{until = {joint = \"elbwo\", current_above_a = 1, within_s = 1}}"),
              "3:19: there is no joint 'elbwo', did you mean elbow?");
    EXPECT_EQ(of_step("{until = {joint = \"elbow\", curent_above_a = 1, within_s = 1}}"),
              "3:28: until has no key 'curent_above_a', did you mean current_above_a?");
    EXPECT_EQ(of_step("{until = {joint = \"elbow\", speed_below_deg_s = -1, within_s = 1}}"),
              "3:48: speed_below_deg_s is a size and must not be below 0.");
    EXPECT_EQ(of_step("{until = {joint = \"elbow\", current_above_a = 1, within_s = 1, on_timeout = \"go\"}}"),
              "3:76: on_timeout must be \"stop\" or \"continue\".");
}

TEST(Motion, ASequenceThatCallsItselfIsFoundHoweverFarAround)
{
    EXPECT_EQ(of_step("{call = \"wave\"}"), "3:9: sequence wave would call itself and never end; use repeat.");
    EXPECT_EQ(complaint("[sequence.a]\nsteps = [{repeat = 2, steps = [{call = \"b\"}]}]\n"
                        "[sequence.b]\nsteps = [{call = \"c\"}]\n"
                        "[sequence.c]\nsteps = [{wait_s = 1}, {call = \"a\"}]\n"),
              "6:32: sequence a would call itself and never end; use repeat.");
    // To call the same one twice is no circle.
    EXPECT_EQ(complaint("[sequence.a]\nsteps = [{call = \"b\"}, {call = \"b\"}]\n"
                        "[sequence.b]\nsteps = [{wait_s = 1}]\n"),
              "nothing");
}

TEST(Motion, NestingEndsWhereNobodyCanFollow)
{
    const auto chain = [](int length) {
        std::string text;
        for (int i = 0; i < length; ++i)
            text += "[sequence.s" + std::to_string(i) + "]\nsteps = [{" +
                    (i + 1 < length ? "call = \"s" + std::to_string(i + 1) + "\"" : std::string{"wait_s = 1"}) + "}]\n";
        return text;
    };
    EXPECT_EQ(complaint(chain(16)), "nothing");
    EXPECT_EQ(complaint(chain(17)), "32:18: calls are nested more than 16 deep.");
    const auto nested = [](int depth) {
        std::string step = "{wait_s = 1}";
        for (int i = 1; i < depth; ++i)
            step.insert(0, "{repeat = 2, steps = [").append("]}");
        return step;
    };
    EXPECT_EQ(of_step(nested(16)), "nothing");
    EXPECT_NE(of_step(nested(17)).find("steps are nested more than 16 deep."), std::string::npos);
    // Half by repetition, half by calls: seen only together.
    const std::string both = "[sequence.deep]\nsteps = [" + nested(10) + "]\n[sequence.wide]\nsteps = [";
    EXPECT_EQ(complaint(both + "{repeat = 2, steps = [{call = \"deep\"}]}]\n"), "nothing");
    std::string call = "{call = \"deep\"}";
    for (int i = 0; i < 6; ++i)
        call.insert(0, "{repeat = 2, steps = [").append("]}");
    EXPECT_NE(complaint(both + call + "]\n").find("sequence wide is nested more than 16 deep with all that it calls."),
              std::string::npos);
}

TEST(Motion, APoseAndASequenceDoNotShareAName)
{
    EXPECT_EQ(complaint("[sequence.ready]\nsteps = [{wait_s = 1}]\n"),
              "1:11: ready is a pose already; a sequence needs another name.");
}

TEST(Motion, AJointHasLimitsOfAccelerationAndJerk)
{
    const std::string file = "version = 1\n[bus.left]\nfamily = \"sam\"\n[joint.elbow]\nbus = \"left\"\nid = 3\n";
    const auto read = parse_robot_file(file + "acceleration_max_deg_s2 = 180\njerk_max_rad_s3 = 9\n", "r.toml");
    ASSERT_TRUE(read);
    EXPECT_DOUBLE_EQ(*read->joints[0].acceleration_max_rad_s2, std::numbers::pi);
    EXPECT_EQ(read->joints[0].jerk_max_rad_s3, 9.0);
    EXPECT_EQ(parse_robot_file(file + "acceleration_max_deg_s2 = 0\n", "r.toml").error().detail,
              "r.toml:7:27: acceleration_max_deg_s2 must be above 0.");
    EXPECT_EQ(parse_robot_file(file + "jerk_max_deg_s3 = -1\n", "r.toml").error().detail,
              "r.toml:7:19: jerk_max_deg_s3 must be above 0.");
}

} // namespace
} // namespace sinew::config
