#include "tests/robot/rig.hpp"

#include <array>
#include <gtest/gtest.h>

/// A mixed robot by its joints: units, enabling, cycles, states.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

TEST(Robot, EveryJointOfTheDemoHoldsAfterEnableAndGoesWhereItIsSent)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_EQ(rig.robot->joints().size(), 16U);
    for (Joint& joint : rig.robot->joints()) {
        EXPECT_NEAR(*joint.state().position_rad, 0.0, 2 * joint.capabilities().position_step_rad) << joint.name();
        EXPECT_EQ(joint.command().mode, Mode::hold);
        const double to =
            joint.limits().position_low_rad.value_or(-1) < units::rad(-60) ? units::rad(-20) : units::rad(20);
        const auto set = joint.set({.mode = Mode::position, .position_rad = to, .velocity_rad_s = units::rad(40)});
        ASSERT_TRUE(set.has_value()) << said(set);
    }
    const auto ran = rig.run(2s);
    ASSERT_TRUE(ran.has_value()) << said(ran);
    for (const Joint& joint : rig.robot->joints()) {
        const double step = joint.capabilities().position_step_rad;
        const double to = *joint.command().position_rad;
        EXPECT_NEAR(rig.truth_rad(joint), to, step) << joint.name();
        EXPECT_NEAR(*joint.state().position_rad, rig.truth_rad(joint), step) << joint.name();
        EXPECT_EQ(joint.failures(), 0U) << joint.name();
        EXPECT_LT(joint.state().position_rad.age(rig.now()), 50ms) << joint.name();
        EXPECT_TRUE(joint.state().velocity_rad_s.has_value()) << joint.name();
    }
    EXPECT_TRUE(rig.robot->incidents().empty()) << rig.robot->incidents()[0].says;
}

TEST(Robot, AJointTurnsByItsDirectionZeroAndRatio)
{
    Rig rig(file_of(R"(
version = 1
[bus.r]
family = "rmd"
[joint.knee]
bus = "r"
id = 1
model = "MG"
profile = "rmd-2.35"
direction = -1
zero_deg = 30
ratio = 2
velocity_max_deg_s = 90
)"));
    rig.enable();
    Joint& knee = *rig.robot->find("knee");
    EXPECT_NEAR(*knee.state().position_rad, units::rad(15), 1e-3) << "(0 - 30) / (-1 * 2)";
    ASSERT_TRUE(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(45)}));
    ASSERT_TRUE(rig.run(1s));
    EXPECT_NEAR(*knee.state().velocity_rad_s, units::rad(45), units::rad(1));
    EXPECT_NEAR(rig.simulator->world().look("knee")->velocity_rad_s, units::rad(-90), units::rad(2));
    ASSERT_TRUE(knee.set({.mode = Mode::position, .position_rad = units::rad(-10)}));
    ASSERT_TRUE(rig.run(2s));
    EXPECT_NEAR(rig.simulator->world().look("knee")->position_rad, units::rad(50), units::rad(0.02));
}

TEST(Robot, AMoveWithAVelocityOrADurationTakesItsTimeInEveryFamily)
{
    for (const bool timed : {false, true}) {
        Rig rig(demo());
        rig.enable();
        for (Joint& joint : rig.robot->joints()) {
            const double to = joint.name().ends_with("hip") ? units::rad(-20) : units::rad(20);
            Command go{.mode = Mode::position, .position_rad = to};
            if (timed)
                go.duration = 2s;
            else
                go.velocity_rad_s = units::rad(10);
            const auto set = joint.set(go);
            ASSERT_TRUE(set.has_value()) << said(set);
        }
        ASSERT_TRUE(rig.run(1s));
        for (Joint& joint : rig.robot->joints())
            EXPECT_NEAR(std::abs(units::deg(rig.truth_rad(joint))), 10.0, 1.5) << joint.name() << timed;
        ASSERT_TRUE(rig.run(1300ms));
        for (Joint& joint : rig.robot->joints())
            EXPECT_NEAR(std::abs(units::deg(rig.truth_rad(joint))), 20.0, 0.1) << joint.name() << timed;
    }
}

TEST(Robot, FourMotorsThatAreDrivenByACurrentShareOneFrame)
{
    std::string text = "version = 1\n[bus.r]\nfamily = \"rmd\"\n";
    for (int id = 1; id <= 5; ++id)
        text += fmt::format("[joint.m{0}]\nbus = \"r\"\nid = {0}\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\n"
                            "direction = {1}\n",
                            id, id == 2 ? -1 : 1);
    Rig rig(file_of(text));
    rig.enable();
    int groups = 0, singles = 0;
    rig.robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) {
        if (tapped.verdict != bus::Verdict::sent)
            return;
        groups += tapped.can_id == 0x280 ? 1 : 0;
        singles += tapped.bytes[0] == 0xA1 ? 1 : 0;
    });
    for (Joint& joint : rig.robot->joints())
        ASSERT_EQ(said(joint.set({.mode = Mode::current, .current_a = 0.5})), "");
    for (int i = 0; i < 10; ++i)
        ASSERT_EQ(said(rig.robot->cycle()), "");
    EXPECT_EQ(groups, 10);
    EXPECT_EQ(singles, 10) << "of the fifth, whose id has no place in the frame";
    ASSERT_EQ(said(rig.run(100ms)), "");
    for (const Joint& joint : rig.robot->joints()) {
        EXPECT_NEAR(*joint.state().current_a, 0.5, 0.05) << joint.name();
        EXPECT_GT(rig.truth_rad_s(joint.name()), 0.0) << joint.name() << ": positive is the joint's own sense";
        EXPECT_EQ(joint.failures(), 0U) << joint.name();
    }
    ASSERT_EQ(said(rig.robot->set("m3", {.mode = Mode::hold})), "");
    groups = 0;
    ASSERT_EQ(said(rig.robot->cycle()), "");
    EXPECT_EQ(groups, 0) << "a group that is not whole would drive the third";
}

/// The others of its group do.
TEST(Robot, AMotorOfAGroupThatAnswersNothingIsSilent)
{
    std::string text = "version = 1\n[bus.r]\nfamily = \"rmd\"\n";
    for (int id = 1; id <= 3; ++id)
        text += fmt::format("[joint.m{0}]\nbus = \"r\"\nid = {0}\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\n", id);
    Rig rig(file_of(text));
    rig.enable();
    for (Joint& joint : rig.robot->joints())
        ASSERT_EQ(said(joint.set({.mode = Mode::current, .current_a = 0.1})), "");
    ASSERT_EQ(said(rig.run(100ms)), "");
    rig.inject(sim::FaultKind::unplug, "m2");
    const auto ran = rig.run(2s);
    EXPECT_NE(said(ran).find("m2"), std::string::npos) << said(ran);
    EXPECT_NE(said(ran).find("has not answered"), std::string::npos) << said(ran);
}

TEST(Robot, ACoarserResolutionMakesShorterMessages)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\n"
                    "model = \"SAM-160EO200\"\n"));
    rig.enable();
    std::size_t bytes = 0;
    rig.robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) { bytes += tapped.bytes.size(); });
    std::array<std::size_t, 2> took{};
    for (const bool coarse : {false, true}) {
        Command go{.mode = Mode::position, .position_rad = 0.1};
        if (coarse)
            go.resolution_rad = units::rad(2);
        ASSERT_EQ(said(rig.robot->set("arm", go)), "");
        ASSERT_EQ(said(rig.robot->cycle()), "");
        bytes = 0;
        ASSERT_EQ(said(rig.robot->cycle()), "");
        took[coarse ? 1 : 0] = bytes;
    }
    EXPECT_LT(took[1], took[0]);
}

TEST(Robot, AFreshStateOfAllJointsComesAtOnceAndTellsWhoIsMissing)
{
    Rig rig(demo());
    ASSERT_EQ(said(rig.robot->read(Depth::full)), "") << "before enable too";
    const TimePoint before = rig.now();
    ASSERT_EQ(said(rig.robot->read(Depth::motion)), "");
    for (const Joint& joint : rig.robot->joints()) {
        EXPECT_GE(joint.state().position_rad.at(), before) << joint.name();
        EXPECT_TRUE(joint.state().position_rad_at(rig.now()).has_value()) << joint.name();
    }
    rig.inject(sim::FaultKind::unplug, "neck_yaw");
    const auto read = rig.robot->read(Depth::motion);
    ASSERT_FALSE(read.has_value());
    EXPECT_NE(said(read).find("neck_yaw"), std::string::npos) << said(read);
}

TEST(Robot, EveryJointComesHome)
{
    auto file = demo();
    for (auto& joint : file.joints)
        joint.home.velocity_rad_s = units::rad(30);
    Rig rig(file);
    rig.enable();
    EXPECT_TRUE(rig.robot->find("elbow")->referenced());
    EXPECT_TRUE(rig.robot->find("left_knee")->referenced()) << "its range lies within the first turn";
    EXPECT_FALSE(rig.robot->find("left_hip")->referenced()) << "its range does not";
    EXPECT_FALSE(rig.robot->find("waist_yaw")->referenced());
    for (Joint& joint : rig.robot->joints())
        ASSERT_EQ(said(joint.set({.mode = Mode::position,
                                  .position_rad = units::rad(joint.name().ends_with("hip") ? -20 : 20),
                                  .velocity_rad_s = units::rad(60)})),
                  "");
    ASSERT_EQ(said(rig.run(1s)), "");
    ASSERT_EQ(said(rig.robot->home()), "");
    for (const Joint& joint : rig.robot->joints())
        EXPECT_NEAR(units::deg(rig.truth_rad(joint)), 0.0, 0.6) << joint.name();
    EXPECT_EQ(rig.robot->incidents().size(), 9U) << "four Nuri, and five RMD that may stand in another turn";
}

TEST(Robot, IncidentsThatAreNoLongerKeptAreCounted)
{
    Rig rig(demo());
    rig.enable();
    constexpr std::size_t each = 9, times = 30; // as above
    for (std::size_t i = 0; i < times; ++i)
        ASSERT_EQ(said(rig.robot->home()), "");
    EXPECT_EQ(rig.robot->incidents().size(), Incidents::most);
    EXPECT_EQ(rig.robot->incidents_dropped(), each * times - Incidents::most);
}

constexpr std::string_view waist_with_a_stop = R"(
version = 1
[bus.n]
family = "nuri"
bit_rate = 115200
[joint.waist]
bus = "n"
id = 1
position_min_deg = -30
position_max_deg = 90
velocity_max_deg_s = 60
[joint.waist.home]
routine = "stop"
direction = -1
position_deg = -35
velocity_deg_s = 20
)";

/// A waist whose stop is at -70 degrees of the device, which only the simulator knows, and what the host knows more.
Rig rig_with_a_stop(std::string_view host = "")
{
    return {file_of(std::string(waist_with_a_stop) + "[joint.waist.plant]\nstop_min_deg = -70\n"),
            file_of(std::string(waist_with_a_stop) + std::string(host))};
}

TEST(Robot, AJointFindsItsReferenceAtAStop)
{
    auto rig = rig_with_a_stop();
    rig.enable();
    EXPECT_FALSE(rig.robot->find("waist")->referenced());
    ASSERT_EQ(said(rig.robot->home("waist")), "");
    EXPECT_TRUE(rig.robot->find("waist")->referenced());
    // The stop is at -70 of the device and at -35 of the joint.
    EXPECT_NEAR(units::deg(rig.simulator->world().look("waist")->position_rad), -35.0, 1.0);
    EXPECT_NEAR(units::deg(*rig.robot->state("waist")->position_rad), 0.0, 0.6);
}

TEST(Robot, AJointFindsItsReferenceAlthoughItsCommandsTimeOut)
{
    auto rig = rig_with_a_stop("[safety]\ncommand_timeout_s = 0.2\n");
    rig.enable();
    ASSERT_EQ(said(rig.robot->home("waist")), "");
    EXPECT_NEAR(units::deg(rig.simulator->world().look("waist")->position_rad), -35.0, 1.0)
        << "it took standing still without a command for its stop";
}

TEST(Robot, AModelThatIsNotTheDevicesOwnIsNotEnabled)
{
    const auto with_model = [](std::string_view model) {
        return file_of(fmt::format("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.servo]\nbus = \"s\"\nid = 1\n"
                                   "model = \"{}\"\n",
                                   model));
    };
    Rig rig(with_model("SAM-20"), with_model("SAM-28"));
    const auto on = rig.robot->enable();
    ASSERT_FALSE(on.has_value());
    EXPECT_NE(said(on).find("SAM-20"), std::string::npos) << said(on);
    EXPECT_NE(said(on).find("SAM-28"), std::string::npos) << said(on);
    EXPECT_FALSE(rig.robot->enabled());
    EXPECT_FALSE(rig.robot->set("servo", {.mode = Mode::hold}));
}

TEST(Robot, AGearThatIsNotTheDevicesOwnIsNotEnabledAndNothingMoves)
{
    const auto with_gear = [](std::string_view ratio) {
        return file_of(
            fmt::format("version = 1\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n[joint.waist]\nbus = \"n\"\n"
                        "id = 1\n[joint.waist.profile_options]\nexternal_gear_ratio = {}\n",
                        ratio));
    };
    Rig rig(with_gear("2.5"), with_gear("1.0"));
    int commands = 0;
    rig.robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) {
        wire::Frame frame{.size = static_cast<std::uint8_t>(tapped.bytes.size())};
        std::ranges::copy(tapped.bytes, frame.data.begin());
        const auto* message = rig.robot->buses()[0]->protocol().identify(frame, wire::Direction::request,
                                                                         line_of(rig.robot->joints()[0].device()));
        commands += tapped.verdict == bus::Verdict::sent && message->info.access != wire::Access::read ? 1 : 0;
    });
    const auto on = rig.robot->enable();
    ASSERT_FALSE(on.has_value());
    EXPECT_NE(said(on).find("waist has the gear ratio 2.5, and the robot file says 1"), std::string::npos) << said(on);
    EXPECT_EQ(commands, 0);
    EXPECT_FALSE(rig.robot->enabled());
}

TEST(Robot, HearsOnACanInterfaceTheIdentifiersOfItsJointsOnly)
{
    const auto file = file_of("version = 1\n[bus.legs]\nfamily = \"rmd\"\n"
                              "[joint.hip]\nbus = \"legs\"\nid = 1\nprofile = \"rmd-2.35\"\n"
                              "[joint.knee]\nbus = \"legs\"\nid = 18\nprofile = \"lk-2.36\"\n");
    const auto simulator = *sim::Simulator::make(file);
    std::vector<std::string> opened;
    link::Links links;
    links.add({.name = "can",
               .form = "can:INTERFACE",
               .says = "An interface of this test.",
               .options = {"ids"},
               .open = [&](const link::Uri& uri, link::Clock&) {
                   opened.push_back(link::to_string(uri));
                   return simulator->open("legs");
               }});
    auto robot = Robot::open(file, links, simulator->clock(), {.links = {{"legs", "can:can0"}}});
    ASSERT_TRUE(robot) << to_sentence(robot.error());
    EXPECT_EQ(opened, std::vector<std::string>{"can:can0?ids=141,152,192"}) << "the second answers from 180h on";
}

TEST(Robot, OfMoreBusesThanItsGuardianHasPlacesForIsNotOpened)
{
    const auto with_buses = [](int count) {
        std::string text = "version = 1\n";
        for (int i = 0; i < count; ++i)
            text += fmt::format("[bus.b{0}]\nfamily = \"rmd\"\n[joint.j{0}]\nbus = \"b{0}\"\nid = 1\n", i);
        return file_of(text);
    };
    const auto file = with_buses(17);
    const auto simulator = *sim::Simulator::make(file);
    const auto robot = Robot::open(file, links_of(*simulator), simulator->clock(), {.simulated = true});
    ASSERT_FALSE(robot.has_value());
    const auto why = to_sentence(robot.error());
    EXPECT_NE(why.find("a robot has at most 16 buses, and this one has 17"), std::string::npos) << why;
    Rig sixteen(with_buses(16));
    EXPECT_EQ(sixteen.robot->buses().size(), 16U);
}

TEST(Robot, AnUnknownJointIsAnErrorWithTheNearestName)
{
    Rig rig(demo());
    const auto set = rig.robot->set("elbo", {.mode = Mode::hold});
    ASSERT_FALSE(set.has_value());
    EXPECT_NE(said(set).find("elbow"), std::string::npos);
    EXPECT_FALSE(rig.robot->state("elbo").has_value());
}

TEST(Robot, ASlowBusNeverHoldsUpAFastOne)
{
    auto file = demo();
    for (auto& bus : file.buses)
        if (bus.name == "waist")
            bus.bit_rate = config::Marked<std::int64_t>{9600, {}};
    Rig rig(file);
    rig.enable();
    int calls = 0;
    Duration oldest_fast{}, oldest_slow{};
    const auto ran = rig.robot->run(
        2ms,
        [&](Robot& robot) {
            if (++calls < 200)
                return;
            for (const Joint& joint : robot.joints()) {
                auto& oldest = joint.bus() == "legs" ? oldest_fast : oldest_slow;
                oldest = std::max(oldest, *joint.state().position_rad.age(rig.now()));
            }
        },
        rig.now() + 2s);
    ASSERT_TRUE(ran.has_value()) << said(ran);
    EXPECT_GE(calls, 990);
    EXPECT_LT(oldest_fast, 8ms);
    EXPECT_GT(oldest_slow, 20ms) << "its age says how old it is";
}

} // namespace
} // namespace sinew::robot::test
