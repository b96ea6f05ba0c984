#include "sinew/family/families.hpp"
#include "sinew/family/sam/messages.hpp"

#include <gtest/gtest.h>
#include <map>
#include <set>

namespace sinew {
namespace {

TEST(DemoRobot, HasEveryFamilyAndEverySamModel)
{
    const auto file = config::read_robot_file(std::filesystem::path{__FILE__}.parent_path() / "../../robots/demo.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    const auto robot = resolve(*file);
    ASSERT_TRUE(robot) << to_sentence(robot.error());
    std::map<std::string_view, std::set<std::string_view>> models;
    std::map<std::string_view, int> joints;
    std::set<bool> acknowledged;
    for (const ResolvedJoint& joint : robot->joints) {
        models[joint.family->name].insert(model_of(joint.device));
        ++joints[joint.family->name];
        if (joint.family->name == "sam")
            acknowledged.insert(answers(joint.device, wire::info_of<sam::SetPdGain>));
        EXPECT_TRUE(joint.joint->position_min_rad && joint.joint->position_max_rad && joint.joint->velocity_max_rad_s)
            << joint.joint->name;
        if (const auto* rmd = std::get_if<rmd::Spec>(&joint.device)) {
            EXPECT_TRUE(rmd->profile.max_speed_confirmed) << joint.joint->name;
        }
    }
    EXPECT_EQ(file->buses.size(), 3U);
    EXPECT_EQ(joints["sam"], 6);
    EXPECT_EQ(models["sam"].size(), 6U);
    EXPECT_EQ(joints["nuri"], 4);
    EXPECT_EQ(joints["rmd"], 6);
    EXPECT_EQ(models["rmd"], (std::set<std::string_view>{"MF", "MG"}));
    EXPECT_EQ(acknowledged.size(), 2U) << "some acknowledge commands and some do not";
}

} // namespace
} // namespace sinew
