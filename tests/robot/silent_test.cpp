#include "tests/robot/lossy_can.hpp"

#include <utility>

/// What a joint is told that does not answer any more.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

TEST(Silent, AStopDoesNotWaitLongForAJointThatIsUnplugged)
{
    auto file = demo();
    file.safety.silence_max_s = 100.0;
    bus::Settings patient;
    patient.margin_at_first = patient.margin_least = patient.margin_most = 1s;
    Rig rig(file, patient);
    rig.enable();
    for (const auto* joint : {"elbow", "waist_yaw", "left_hip"})
        ASSERT_EQ(said(rig.robot->set(joint, {.mode = Mode::position, .position_rad = 0.4, .velocity_rad_s = 0.1})),
                  "");
    ASSERT_EQ(said(rig.run(500ms)), "");
    rig.inject(sim::FaultKind::unplug, "elbow");
    rig.simulator->clock().wait({}, rig.now() + 50ms);
    const TimePoint begun = rig.now();
    for (const auto& one : rig.robot->stop())
        EXPECT_EQ(one.outcome, one.joint == "elbow" ? Stopped::Outcome::failed : Stopped::Outcome::confirmed)
            << one.joint;
    EXPECT_LT(rig.now() - begun, 5s) << "four time-outs, and looks at those that are there";
}

/// A joint of each family on a bus of its own, with patience for silence.
constexpr std::string_view three = R"(
version = 1
[safety]
silence_max_s = 20
[bus.s]
family = "sam"
[bus.n]
family = "nuri"
bit_rate = 115200
[bus.r]
family = "rmd"
[joint.sam]
bus = "s"
id = 1
model = "SAM-20"
[joint.nuri]
bus = "n"
id = 1
[joint.rmd]
bus = "r"
id = 1
model = "MG"
profile = "rmd-2.35"
[joint.rmd.profile_options]
torque_constant_nm_per_a = 1.0
)";

/// It hears, and is not heard.
void hush(Rig& rig, std::string_view joint)
{
    sim::Fault late{.kind = sim::FaultKind::delay_replies, .joint = std::string(joint)};
    late.probability = 1.0;
    late.delay_s = 100.0;
    rig.simulator->world().inject(late);
}

/// How fast a joint turns that turned, fell silent, and was told this, half a second later.
double speed_after(std::string_view joint, const Command& turns, const Command& then)
{
    Rig rig(file_of(three));
    rig.enable();
    EXPECT_EQ(said(rig.robot->set(joint, turns)), "");
    EXPECT_EQ(said(rig.run(500ms)), "");
    EXPECT_GT(rig.truth_rad_s(joint), 0.2) << joint;
    hush(rig, joint);
    EXPECT_EQ(said(rig.run(300ms)), "");
    EXPECT_EQ(said(rig.robot->set(joint, then)), "");
    EXPECT_EQ(said(rig.run(500ms)), "");
    return rig.truth_rad_s(joint);
}

/// Told again in every cycle, a Nuri begins its 0.1 s to rest anew and again: after half a second e^-5 of 1 rad/s is
/// left.
constexpr double slow = 0.007;

TEST(Silent, AJointWhoseAnswersAreMissingIsToldAtOnceToTurnNoMore)
{
    const Command turn{.mode = Mode::velocity, .velocity_rad_s = 1.0};
    for (const auto* joint : {"sam", "nuri", "rmd"}) {
        EXPECT_NEAR(speed_after(joint, turn, {.mode = Mode::velocity, .velocity_rad_s = 0.0}), 0.0, slow) << joint;
        EXPECT_NEAR(speed_after(joint, turn, {.mode = Mode::hold}), 0.0, slow) << joint;
    }
    const Command duty{.mode = Mode::duty, .duty = 0.2};
    EXPECT_NEAR(speed_after("sam", duty, {.mode = Mode::duty, .duty = 0.0}), 0.0, slow);
}

TEST(Silent, AJointWhoseAnswersAreMissingIsToldAtOnceToPushNoMore)
{
    for (const Command& push :
         {Command{.mode = Mode::current, .current_a = 0.5}, Command{.mode = Mode::torque, .torque_nm = 0.5}}) {
        Rig rig(file_of(three));
        rig.enable();
        ASSERT_EQ(said(rig.robot->set("rmd", push)), "");
        ASSERT_EQ(said(rig.run(100ms)), "");
        hush(rig, "rmd");
        ASSERT_EQ(said(rig.run(300ms)), "");
        ASSERT_GT(std::abs(rig.simulator->world().look("rmd")->current_a), 0.1);
        Command none = push;
        (push.mode == Mode::current ? none.current_a : none.torque_nm) = 0.0;
        ASSERT_EQ(said(rig.robot->set("rmd", none)), "");
        ASSERT_EQ(said(rig.run(100ms)), "");
        EXPECT_NEAR(rig.simulator->world().look("rmd")->current_a, 0.0, 1e-3);
    }
}

/// It may have lost its supply and be limp: nothing new may set it in motion, and what it did before ends.
TEST(Silent, AJointThatTurnsAndWhoseAnswersAreMissingIsStoppedBeforeItDoesAnythingElse)
{
    const Command turn{.mode = Mode::velocity, .velocity_rad_s = 1.0};
    for (const auto* joint : {"sam", "nuri", "rmd"})
        for (const Command& other : {Command{.mode = Mode::velocity, .velocity_rad_s = -1.0},
                                     Command{.mode = Mode::velocity, .velocity_rad_s = 0.3},
                                     Command{.mode = Mode::position, .position_rad = 0.5, .velocity_rad_s = 0.3}})
            EXPECT_NEAR(speed_after(joint, turn, other), 0.0, slow) << joint << to_word(other.mode);
    EXPECT_GT(speed_after("rmd", turn, turn), 0.2) << "the same is no reason";
}

/// How often a SAM that holds is thought to have started afresh, which is looked at every `period` and gives no answer
/// to so many looks; the loop stands still for `pause` after them.
std::size_t restarts(Duration period, int looks, Duration pause = {})
{
    bus::Settings once;
    once.read_retries = 0;
    Rig rig(file_of(three), once);
    rig.enable();
    EXPECT_EQ(said(rig.run(1s, period)), "");
    sim::Fault lost{.kind = sim::FaultKind::drop_bytes, .bus = "s"};
    rig.simulator->world().inject(lost);
    rig.simulator->clock().wait({}, rig.now() + 1ms); // it begins with a step of the world
    const auto failures = rig.robot->find("sam")->failures();
    EXPECT_EQ(said(rig.run(looks * period, period)), "");
    EXPECT_GE(rig.robot->find("sam")->failures(), failures + looks);
    rig.simulator->world().mend("s");
    rig.simulator->clock().wait({}, rig.now() + pause);
    EXPECT_EQ(said(rig.run(2s, period)), "");
    return rig.robot->incidents().size();
}

TEST(Silent, OneLostAnswerOfASlowBusIsNoRestart)
{
    EXPECT_EQ(restarts(200ms, 1), 0U);
    EXPECT_EQ(restarts(1s, 1), 0U);
    EXPECT_EQ(restarts(200ms, 3), 1U) << "three of them are";
    EXPECT_EQ(restarts(60ms, 1), 0U);
    EXPECT_EQ(restarts(60ms, 3), 1U);
}

TEST(Silent, ALoopThatStoodStillAfterALostAnswerTakesThatForASilence)
{
    EXPECT_EQ(restarts(60ms, 1, 3s), 1U);
    EXPECT_EQ(restarts(200ms, 1, 3s), 1U);
}

TEST(Silent, ASilenceAfterALoopStoodStillOnceIsARestartAllTheSame)
{
    Rig rig(file_of(three));
    rig.enable();
    ASSERT_EQ(said(rig.run(1s)), "");
    rig.simulator->clock().wait({}, rig.now() + 3s);
    rig.inject(sim::FaultKind::unplug, "sam", 0.4);
    ASSERT_EQ(said(rig.run(2s)), "");
    EXPECT_EQ(rig.robot->incidents().size(), 1U);
}

/// What is said of joints that are silent from now on, in a loop that stands still once for `pause`.
std::string blamed(Duration pause, bool own_loop)
{
    auto file = file_of(three);
    file.safety.silence_max_s = 1.0;
    Rig rig(file);
    rig.enable();
    EXPECT_EQ(said(rig.run(500ms)), "");
    for (const auto* joint : {"sam", "nuri", "rmd"})
        hush(rig, joint);
    const auto stand_still = [&] { rig.simulator->clock().wait({}, rig.now() + std::exchange(pause, Duration{})); };
    if (!own_loop)
        return said(rig.robot->run(10ms, [&](Robot&) { stand_still(); }, rig.now() + 5s));
    for (int i = 0; i < 200; ++i) {
        if (auto turn = rig.robot->cycle(); !turn)
            return said(turn);
        stand_still();
    }
    return {};
}

TEST(Silent, AProgramThatStoodStillDoesNotBlameItsDevicesAlone)
{
    for (const bool own_loop : {false, true}) {
        EXPECT_NE(blamed(1500ms, own_loop).find("But this program itself stood still for 1.5"), std::string::npos)
            << own_loop;
        EXPECT_NE(blamed(700ms, own_loop).find("But this program itself stood still for 0.7"), std::string::npos)
            << own_loop;
        EXPECT_NE(blamed({}, own_loop).find("it has not answered for 1."), std::string::npos) << own_loop;
        for (const Duration pause : {Duration{}, Duration{300ms}})
            EXPECT_EQ(blamed(pause, own_loop).find("stood still"), std::string::npos) << "most of it was the devices'";
    }
}

/// Nobody acknowledges what a Nuri is told, and it answers where it is all the same.
TEST(Silent, ANuriOfWhichTheStopWasLostIsToldAgainAlthoughItAnswers)
{
    for (int seed = 1; seed <= 100; ++seed) {
        Rig rig(file_of(fmt::format("{}[sim]\nseed = {}\n", three, seed)));
        rig.enable();
        ASSERT_EQ(said(rig.robot->set("nuri", {.mode = Mode::velocity, .velocity_rad_s = 0.4})), "");
        ASSERT_EQ(said(rig.run(300ms)), "");
        sim::Fault noise{.kind = sim::FaultKind::drop_bytes, .bus = "n"};
        noise.probability = 0.1;
        noise.for_s = 0.02;
        rig.simulator->world().inject(noise);
        rig.simulator->clock().wait({}, rig.now() + 1ms); // it begins with a step of the world
        const auto stopped = rig.robot->stop();
        rig.simulator->clock().wait({}, rig.now() + 500ms);
        EXPECT_EQ(stopped[1].outcome, Stopped::Outcome::confirmed) << seed;
        EXPECT_NEAR(rig.truth_rad_s("nuri"), 0.0, slow) << seed;
    }
}

constexpr std::string_view lk_arm = R"(
version = 1
[safety]
policy = "hold"
[bus.r]
family = "rmd"
[joint.knee]
bus = "r"
id = 1
model = "MG"
profile = "lk-2.35"
velocity_max_deg_s = 60
[joint.knee.plant]
gravity_torque_nm = 5
gravity_zero_deg = -60
)";

constexpr std::uint8_t motor_off = 0x80, speed_closed_loop = 0xA2, read_status_1 = 0x9A;

/// A frame of the stop is lost that takes more than one of them; the answers to the others are no news of that.
TEST(Silent, AJointThatWasBrakedAndOfWhichTheHoldOfAStopIsLostIsToldAgain)
{
    for (int lost = 1; lost <= 2; ++lost) {
        LossyRobot one{std::string(lk_arm)};
        ASSERT_EQ(said(one.run({.mode = Mode::hold}, 100ms)), "");
        ASSERT_EQ(said(one.run({.mode = Mode::brake}, 100ms)), "");
        int holds = 0; // the first of which is that of the ready-made stop, to a motor that is off
        one.losses.of_sent = [&](const wire::Frame& frame) {
            holds += frame.data[0] == speed_closed_loop ? 1 : 0;
            return frame.data[0] == speed_closed_loop && holds > 1 && holds <= 1 + lost;
        };
        EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed) << lost;
        EXPECT_GT(std::abs(one.simulator->world().look("knee")->current_a), 0.1) << "it is limp";
    }
}

TEST(Silent, AJointThatNeverHeardTheHoldOfAStopIsNotSaidToHold)
{
    LossyRobot one{std::string(lk_arm)};
    ASSERT_EQ(said(one.run({.mode = Mode::hold}, 500ms)), "");
    one.losses.of_sent = [](const wire::Frame& frame) { return frame.data[0] == speed_closed_loop; };
    EXPECT_NE(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
}

/// The stop is lost in noise and so is every answer, for some time.
TEST(Silent, AJointThatHearsNothingOfAStopForAWhileIsStoppedAllTheSame)
{
    for (const auto* joint : {"sam", "nuri", "rmd"}) {
        Rig rig(file_of(three));
        rig.enable();
        ASSERT_EQ(said(rig.robot->set(joint, {.mode = Mode::velocity, .velocity_rad_s = 0.4})), "");
        ASSERT_EQ(said(rig.run(300ms)), "");
        sim::Fault noise{.kind = sim::FaultKind::drop_bytes, .bus = std::string(1, joint[0]), .for_s = 0.25};
        rig.simulator->world().inject(noise);
        rig.simulator->clock().wait({}, rig.now() + 1ms); // it begins with a step of the world
        (void)rig.robot->stop();
        rig.simulator->clock().wait({}, rig.now() + 500ms);
        EXPECT_NEAR(rig.truth_rad_s(joint), 0.0, slow) << joint;
    }
}

/// Another program lets go of it time and again; now and then nothing is heard of that.
TEST(Silent, AJointThatSaysItIsOffIsNotSaidToHold)
{
    std::string text(lk_arm);
    text.replace(text.find("gravity_torque_nm = 5"), 21, "gravity_torque_nm = 0"); // it stands all the same
    LossyRobot one(text);
    ASSERT_EQ(said(one.run({.mode = Mode::hold}, 500ms)), "");
    one.losses.others = [](const wire::Frame& frame) {
        return wire::Frame{.can_id = frame.can_id, .size = 8, .data = {motor_off}};
    };
    int status = 0; // each is asked for twice where no answer comes
    one.losses.of_sent = [&](const wire::Frame& frame) { return frame.data[0] == read_status_1 && ++status % 3 != 1; };
    EXPECT_NE(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
}

/// Noise that begins when it has answered once, and ends.
TEST(Silent, AJointThatAnsweredAndThenMissesAFewLooksOfAStopIsAskedAgain)
{
    LossyRobot one(
        "version = 1\n[safety]\npolicy = \"hold\"\n[bus.r]\nfamily = \"rmd\"\n[joint.knee]\nbus = \"r\"\nid = 1\n"
        "model = \"MG\"\nprofile = \"rmd-2.35\"\nvelocity_max_deg_s = 60\n");
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 500ms)), "");
    std::optional<TimePoint> first;
    one.losses.of_heard = [&](const wire::Frame&) {
        const TimePoint now = one.simulator->clock().now();
        if (!first)
            first = now;
        return now - *first > 5ms && now - *first < 200ms;
    };
    const auto stopped = one.robot->stop();
    EXPECT_EQ(stopped.front().outcome, Stopped::Outcome::confirmed) << to_sentence(stopped.front().why);
    EXPECT_GT(one.simulator->clock().now() - *first, 200ms);
}

} // namespace
} // namespace sinew::robot::test
