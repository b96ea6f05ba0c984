#include "sinew/config/pose_edit.hpp"

#include "sinew/base/units.hpp"

#include <gtest/gtest.h>

namespace sinew::config {
namespace {

constexpr std::string_view head = R"(# my arm
version = 1
[bus.left]   # the blue cable
family = "sam"
[joint.elbow]
bus = "left"
id = 3
position_max_deg = 140
[joint.wrist]
bus = "left"
id = 4
)";

std::string changed(std::string_view tail, std::vector<NewTarget> targets, std::string_view pose = "ready")
{
    const std::string text = std::string(head) + std::string(tail);
    const auto out = with_pose(text, "r.toml", pose, targets);
    if (!out)
        return to_sentence(out.error());
    EXPECT_TRUE(out->starts_with(head)) << *out;
    return out->substr(head.size());
}

const std::vector<NewTarget> both{{"elbow", units::rad(12.3456789)}, {"wrist", units::rad(-90)}};

TEST(PoseEdit, ANewPoseComesAtTheEndOfTheFile)
{
    EXPECT_EQ(changed("", both), "\n[pose.ready]\nelbow_deg = 12.346\nwrist_deg = -90\n");
    EXPECT_EQ(changed("[sim]\nseed = 7 # luck", both),
              "[sim]\nseed = 7 # luck\n\n[pose.ready]\nelbow_deg = 12.346\nwrist_deg = -90\n");
}

TEST(PoseEdit, APoseThatIsThereKeepsItsCommentsItsOrderAndItsUnits)
{
    const std::string_view before = "[pose.ready] # for work\n"
                                    "# the hand first\n"
                                    "\twrist_rad   =  0.1   # flat\n"
                                    "elbow_deg=100\n"
                                    "\n"
                                    "# below\n"
                                    "[pose.rest]\nelbow_deg = 0\n";
    EXPECT_EQ(changed(before, both), "[pose.ready] # for work\n"
                                     "# the hand first\n"
                                     "\twrist_rad   =  -1.5708   # flat\n"
                                     "elbow_deg=12.346\n"
                                     "\n"
                                     "# below\n"
                                     "[pose.rest]\nelbow_deg = 0\n");
}

TEST(PoseEdit, AJointThatThePoseDoesNotHaveComesAfterItsLastOne)
{
    EXPECT_EQ(changed("[pose.ready]\nwrist_deg = 1 # first\n\n# for later\n[pose.rest]\nelbow_deg = 0\n", both),
              "[pose.ready]\nwrist_deg = -90 # first\nelbow_deg = 12.346\n\n# for later\n[pose.rest]\nelbow_deg = 0\n");
    EXPECT_EQ(changed("[pose.ready]\nwrist_deg = 1", both), "[pose.ready]\nwrist_deg = -90\nelbow_deg = 12.346\n");
}

TEST(PoseEdit, AJointThatIsNotTaughtStays)
{
    EXPECT_EQ(changed("[pose.ready]\nwrist_deg = 1\nelbow_deg = 2\n", {{"elbow", 0.0}}),
              "[pose.ready]\nwrist_deg = 1\nelbow_deg = 0\n");
}

TEST(PoseEdit, TheLinesOfAnotherSystemKeepTheirEnds)
{
    EXPECT_EQ(changed("[pose.ready]\r\nwrist_deg = 1\r\n", both),
              "[pose.ready]\r\nwrist_deg = -90\r\nelbow_deg = 12.346\r\n");
}

TEST(PoseEdit, APositionBeyondTheLimitsOfItsJointIsRefused)
{
    EXPECT_EQ(changed("", {{"elbow", units::rad(141)}}),
              "r.toml:14:13: elbow at 141 deg is beyond its position_max_deg: 140 deg.");
}

TEST(PoseEdit, WhatIsNotATableOfItsOwnIsLeftAlone)
{
    const std::string own =
        "write the pose ready of r.toml as a table of its own, [pose.ready], so that its lines can be "
        "changed";
    EXPECT_EQ(changed("[pose]\nready = {elbow_deg = 3}\n", both), own);
    EXPECT_EQ(changed("pose.ready = {elbow_deg = 3}\n", both, "ready").substr(0, 9), "r.toml:12");
    EXPECT_EQ(changed("[pose]\nready.elbow_deg = 3\n", both), own);
}

TEST(PoseEdit, NamesThatCannotBeThoseOfAPoseAreRefused)
{
    EXPECT_EQ(changed("", both, "a b"), "the name of a pose may only have letters, digits, - and _, not 'a b'");
    EXPECT_EQ(changed("[sequence.nod]\nsteps = [{wait_s = 1}]\n", both, "nod"),
              "nod is a sequence of r.toml; a pose needs another name");
    EXPECT_EQ(changed("", {{"elbwo", 0.0}}), "r.toml:14:1: there is no joint 'elbwo', did you mean elbow?");
}

TEST(PoseEdit, AFileThatIsWrongAlreadyIsLeftAlone)
{
    EXPECT_EQ(changed("[pose.rest]\nelbwo_deg = 1\n", both),
              "r.toml:13:1: there is no joint 'elbwo', did you mean elbow?");
}

} // namespace
} // namespace sinew::config
