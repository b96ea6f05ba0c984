#include "sinew/sim/fault.hpp"

#include "sinew/sim/simulator.hpp"
#include "sinew/sim/world_test_support.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::sim::test {
namespace {

config::RobotFile robot_with(std::string_view more)
{
    const auto file = config::parse_robot_file(std::string(robot_text) + std::string(more), "r.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    return *file;
}

/// What making a world of this robot complains about.
std::string complaint(std::string_view more)
{
    const auto world = World::make(robot_with(more));
    return world ? std::string() : world.error().detail;
}

const int lines = static_cast<int>(std::ranges::count(robot_text, '\n'));

TEST(FaultScript, AJointThatIsNotThereIsSaidWithItsPlaceAndTheNearest)
{
    EXPECT_EQ(complaint("[[sim.fault]]\nkind = \"unplug\"\njoint = \"elbov\"\n"),
              fmt::format("r.toml:{}:1: the robot has no joint 'elbov', did you mean elbow? It has shoulder, elbow, "
                          "twist, bend, hip, knee.",
                          lines + 3));
}

TEST(FaultScript, WhatMakesNoSenseIsRefused)
{
    const auto start = fmt::format("r.toml:{}:", lines + 1);
    EXPECT_EQ(complaint("[[sim.fault]]\njoint = \"elbow\"\n").substr(0, start.size()), start);
    EXPECT_NE(complaint("[[sim.fault]]\nkind = \"unplugg\"\njoint = \"elbow\"\n").find("did you mean unplug?"),
              std::string::npos);
    EXPECT_NE(complaint("[[sim.fault]]\nkind = \"stuck-gear\"\nbus = \"left\"\n").find("hits a joint, not a bus"),
              std::string::npos);
    EXPECT_NE(complaint("[[sim.fault]]\nkind = \"brown-out\"\nbus = \"left\"\n").find("needs voltage_v"),
              std::string::npos);
    EXPECT_NE(complaint("[[sim.fault]]\nkind = \"flip-bits\"\nbus = \"left\"\nprobability = 2\n").find("from 0 to 1"),
              std::string::npos);
    EXPECT_NE(complaint("[sim]\nsead = 3\n").find("did you mean seed?"), std::string::npos);
}

TEST(FaultScript, WordsSayTheSameAsTheFile)
{
    const auto file = robot_with("");
    const std::vector<std::string> words{"elbow", "push", "torque_nm=1.5", "at_s=2", "for_s=3"};
    const auto fault = parse_fault(file, words);
    ASSERT_TRUE(fault) << to_sentence(fault.error());
    EXPECT_EQ(fault->kind, FaultKind::push);
    EXPECT_EQ(fault->joint, "elbow");
    EXPECT_EQ(fault->torque_nm, 1.5);
    EXPECT_EQ(fault->at_s, 2.0);
    EXPECT_EQ(fault->for_s, 3.0);
    const auto complain = [&](std::vector<std::string> wrong) { return parse_fault(file, wrong).error().detail; };
    EXPECT_NE(complain({"elbow"}).find("TARGET KIND"), std::string::npos);
    EXPECT_NE(complain({"elbow", "stuck"}).find("no fault 'stuck'"), std::string::npos);
    EXPECT_NE(complain({"elbow", "push"}).find("needs torque_nm"), std::string::npos);
    EXPECT_NE(complain({"elbow", "push", "torque_nm=heavy"}).find("torque_nm must be"), std::string::npos);
}

TEST(Plants, ImpossiblePhysicsAreRefusedWithTheirPlace)
{
    EXPECT_EQ(complaint("[joint.elbow.plant]\nload_inertia_kg_m2 = -0.1\n"),
              fmt::format("r.toml:{}:1: load_inertia_kg_m2 must be a number from 0 on.", lines + 2));
    EXPECT_NE(complaint("[joint.elbow.plant]\nload_inertia = 1\n").find("did you mean load_inertia_kg_m2?"),
              std::string::npos);
    EXPECT_NE(complaint("[joint.elbow.plant]\nstop_min_deg = 20\nstop_max_deg = 10\n").find("below the upper"),
              std::string::npos);
    EXPECT_NE(complaint("[joint.elbow.plant]\nstatic_friction_nm = 0\n").find("must not be below"), std::string::npos);
    EXPECT_NE(complaint("[bus.left.sim]\nsupply_ohm = -1\n").find("supply_ohm must be"), std::string::npos);
}

/// Where the joint stands after a while under these settings.
double position_after(std::string_view more, Duration time)
{
    const auto world = World::make(robot_with(more));
    EXPECT_TRUE(world) << to_sentence(world.error());
    (*world)->advance(TimePoint{} + time);
    return (*world)->find_device("elbow")->plant().position_rad();
}

TEST(Plants, AWeightPullsDownAReleasedJoint)
{
    EXPECT_EQ(position_after("", 2s), 0.0);
    EXPECT_NEAR(position_after("[joint.elbow.plant]\ngravity_torque_nm = 8\ngravity_zero_deg = 40\n"
                               "load_inertia_kg_m2 = 0.3\n[[sim.fault]]\nkind = \"unplug\"\njoint = \"elbow\"\n",
                               10s),
                0.7, 0.15); // friction holds it short of the lowest point
}

TEST(Plants, APushFromOutsideTurnsTheShaftWhileItLasts)
{
    const std::string_view push =
        "[[sim.fault]]\nkind = \"push\"\njoint = \"elbow\"\ntorque_nm = 5\nat_s = 1\nfor_s = 0.5\n"
        "[[sim.fault]]\nkind = \"unplug\"\njoint = \"elbow\"\n";
    EXPECT_EQ(position_after(push, 990ms), 0.0);
    const double at_end = position_after(push, 1500ms);
    EXPECT_GT(at_end, 0.1);
    EXPECT_EQ(position_after(push, 10s), position_after(push, 20s)) << "friction has brought it to rest";
}

/// A read gives what arrived at one time.
Bytes read_all(link::ByteLink& link)
{
    Bytes all;
    std::array<std::uint8_t, 64> into{};
    for (auto got = link.read(into); got && got->count != 0; got = link.read(into))
        all.insert(all.end(), into.begin(), into.begin() + got->count);
    return all;
}

struct FaultyWorldTest : testing::Test {
    void SetUp() override { simulator = *Simulator::make(robot()); }
    void inject(std::vector<std::string> words)
    {
        const auto fault = parse_fault(robot(), words);
        ASSERT_TRUE(fault) << to_sentence(fault.error());
        simulator->world().inject(*fault);
        wait(2ms);
    }
    void wait(Duration time)
    {
        const TimePoint until = simulator->clock().now() + time;
        while (simulator->clock().now() < until)
            simulator->clock().wait({}, until);
    }
    Bytes ask(link::ByteLink& link, const Bytes& request)
    {
        EXPECT_TRUE(link.write(request));
        wait(5ms);
        return read_all(link);
    }
    link::AnyLink open(std::string_view bus) { return std::move(*simulator->open(bus)); }
    std::unique_ptr<Simulator> simulator;
};

TEST_F(FaultyWorldTest, AnUnpluggedDeviceIsSilentAndComesBackWithoutWhatItDidNotStore)
{
    auto left = open("left");
    EXPECT_EQ(ask(bytes_of(left), sam_status_3).size(), 2U);
    inject({"elbow", "unplug"});
    EXPECT_EQ(simulator->world().look("elbow")->mode, "off");
    EXPECT_EQ(ask(bytes_of(left), sam_status_3).size(), 0U);
    EXPECT_EQ(ask(bytes_of(left), sam_status_0).size(), 2U) << "the others stay";
    EXPECT_EQ(simulator->world().faults_of("elbow"), std::vector{FaultKind::unplug});
    EXPECT_EQ(simulator->world().mend("elbow"), 1U);
    wait(2ms);
    EXPECT_EQ(ask(bytes_of(left), sam_status_3).size(), 2U);
    EXPECT_TRUE(simulator->world().faults_of("elbow").empty());
}

TEST_F(FaultyWorldTest, APowerCutSilencesTheWholeBusForItsTime)
{
    auto waist = open("waist");
    auto left = open("left");
    inject({"waist", "power-cut", "for_s=0.1"});
    wait(20ms); // the supply has a capacitor
    EXPECT_TRUE(ask(bytes_of(waist), nuri_ping_1).empty());
    EXPECT_TRUE(ask(bytes_of(waist), nuri_ping_2).empty());
    EXPECT_EQ(ask(bytes_of(left), sam_status_0).size(), 2U);
    wait(200ms);
    EXPECT_EQ(ask(bytes_of(waist), nuri_ping_1), nuri_pong_1);
}

TEST_F(FaultyWorldTest, ADeviceAtAnotherBitRateDoesNotUnderstand)
{
    auto waist = open("waist");
    inject({"twist", "wrong-baud", "bit_rate=9600"});
    EXPECT_TRUE(ask(bytes_of(waist), nuri_ping_1).empty());
    simulator->world().mend("twist");
    wait(2ms);
    EXPECT_EQ(ask(bytes_of(waist), nuri_ping_1), nuri_pong_1);
}

TEST_F(FaultyWorldTest, TwoDevicesWithOneIdSpeakAtOnce)
{
    auto waist = open("waist");
    inject({"bend", "duplicate-id", "id=1"});
    EXPECT_TRUE(ask(bytes_of(waist), nuri_ping_2).empty());
    EXPECT_FALSE(ask(bytes_of(waist), nuri_ping_1).empty());
    simulator->world().mend("bend");
    wait(2ms);
    EXPECT_EQ(ask(bytes_of(waist), nuri_ping_2), nuri_pong_2);
}

TEST_F(FaultyWorldTest, LostBytesAreLostAndTheSameSeedLosesTheSameOnes)
{
    const auto heard = [](int seed) {
        const auto other = *Simulator::make(robot_with(
            fmt::format("[sim]\nseed = {}\n[[sim.fault]]\nkind = \"drop-bytes\"\nbus = \"waist\"\nprobability = 0.05\n"
                        "[[sim.fault]]\nkind = \"flip-bits\"\njoint = \"bend\"\nprobability = 0.1\n",
                        seed)));
        auto link = *other->open("waist");
        Bytes all;
        for (int i = 0; i < 200; ++i) {
            EXPECT_TRUE(bytes_of(link).write(i % 2 == 0 ? nuri_ping_1 : nuri_ping_2));
            const TimePoint until = other->clock().now() + 10ms;
            while (other->clock().now() < until)
                other->clock().wait({}, until);
            const Bytes heard_now = read_all(bytes_of(link));
            all.insert(all.end(), heard_now.begin(), heard_now.end());
        }
        return all;
    };
    const Bytes first = heard(7);
    EXPECT_LT(first.size(), 1200U);
    EXPECT_GT(first.size(), 400U);
    EXPECT_EQ(first, heard(7));
    EXPECT_NE(first, heard(8));
}

TEST_F(FaultyWorldTest, AHotMotorIsTold)
{
    inject({"hip", "hot-motor", "temperature_c=120"});
    EXPECT_NEAR(simulator->world().look("hip")->temperature_c, 120.0, 1.0);
}

} // namespace
} // namespace sinew::sim::test
