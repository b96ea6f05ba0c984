#include "sinew/family/nuri/messages.hpp"
#include "tests/robot/rig.hpp"

/// Looking for a stop that is not there, or not where it is looked for.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

/// A joint whose stop, if it has one, only the simulator knows.
std::string waist(std::string_view limits, std::string_view home, std::string_view more = "")
{
    return fmt::format(
        "version = 1\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n[joint.waist]\nbus = \"n\"\nid = 1\n"
        "{}\n[joint.waist.home]\nroutine = \"stop\"\n{}\n{}\n",
        limits, home, more);
}

constexpr std::string_view range = "position_min_deg = -90\nposition_max_deg = 90\nvelocity_max_deg_s = 60";

/// How far it turns although there is no stop, and that it stands still then without anybody driving.
double travel_deg(const std::string& text, std::string_view said_deg)
{
    Rig rig(file_of(text));
    rig.enable();
    const double from = rig.truth_rad("waist");
    const auto found = rig.robot->home("waist", 600s);
    EXPECT_NE(said(found).find(
                  fmt::format("waist has turned as far as it may for its stop, {} deg, and found none", said_deg)),
              std::string::npos)
        << said(found);
    const double ended = rig.truth_rad("waist");
    const TimePoint later = rig.now() + 5s;
    while (rig.now() < later)
        rig.simulator->clock().wait({}, later);
    EXPECT_NEAR(units::deg(rig.truth_rad("waist")), units::deg(ended), 1.0) << "it turns on";
    EXPECT_FALSE(rig.robot->find("waist")->referenced());
    return units::deg(std::abs(ended - from));
}

// It is looked at every 10 ms, and comes to rest from 30 deg/s within 5 degrees.
constexpr double reaction_deg = 5.0;

TEST(Home, AJointWithoutAStopIsTurnedAsFarAsItsRangeAndNotForAMinute)
{
    EXPECT_NEAR(travel_deg(waist(range, "direction = -1\nposition_deg = -90\nvelocity_deg_s = 30"), "200"), 200.0,
                reaction_deg);
    EXPECT_NEAR(travel_deg(waist(range, "direction = 1\nposition_deg = 100\nvelocity_deg_s = 30"), "210"), 210.0,
                reaction_deg)
        << "its stop is part of its range";
}

TEST(Home, AJointWithoutLimitsLooksForItsStopForOneTurn)
{
    EXPECT_NEAR(travel_deg(waist("position_min_deg = -90", "velocity_deg_s = 30"), "380"), 380.0, reaction_deg);
}

TEST(Home, AJointLooksForItsStopAsFarAsItsFileSays)
{
    EXPECT_NEAR(travel_deg(waist(range, "velocity_deg_s = 30\ntravel_max_deg = 50"), "50"), 50.0, reaction_deg);
}

TEST(Home, AJointThatIsToTurnFasterThanItMayIsTurnedAsFastAsItMay)
{
    Rig rig(file_of(waist("position_min_deg = -90\nposition_max_deg = 90\nvelocity_max_deg_s = 20",
                          "position_deg = -90\nvelocity_deg_s = 60", "[joint.waist.plant]\nstop_min_deg = -90\n")));
    rig.enable();
    EXPECT_EQ(said(rig.robot->home("waist")), "");
}

TEST(Home, AJointThatWasStoppedAloneIsNotSetInMotion)
{
    Rig rig(file_of(waist(range, "velocity_deg_s = 30", "[safety]\non_fault = \"joint\"\nsilence_max_s = 0.2\n")));
    rig.enable();
    rig.inject(sim::FaultKind::unplug, "waist", 0.5);
    EXPECT_EQ(said(rig.run(1s)), "");
    const double from = rig.truth_rad("waist");
    EXPECT_NE(said(rig.robot->home("waist")), "");
    EXPECT_EQ(said(rig.run(1s)), "");
    EXPECT_NEAR(units::deg(rig.truth_rad("waist")), units::deg(from), 0.5);
}

TEST(Home, OfTwoJointsWithoutAStopNoneTurnsOn)
{
    Rig rig(file_of(waist(range, "velocity_deg_s = 30\ntravel_max_deg = 50",
                          "[joint.neck]\nbus = \"n\"\nid = 2\n[joint.neck.home]\nroutine = \"stop\"\n"
                          "velocity_deg_s = 10\n")));
    rig.enable();
    EXPECT_NE(said(rig.robot->home()).find("waist has turned as far"), std::string::npos);
    const double ended = rig.truth_rad("neck");
    (void)rig.run(2s);
    EXPECT_NEAR(units::deg(rig.truth_rad("neck")), units::deg(ended), 1.0);
}

/// Two servos; `safety`: lines of that table.
std::string servos(std::string_view safety)
{
    return fmt::format("version = 1\n[bus.s]\nfamily = \"sam\"\n[safety]\n{}\n"
                       "[joint.arm]\nbus = \"s\"\nid = 1\nmodel = \"SAM-20\"\nvelocity_max_deg_s = 60\n"
                       "[joint.arm.sim]\nstart_rad = 1.2\n"
                       "[joint.wrist]\nbus = \"s\"\nid = 2\nmodel = \"SAM-20\"\nvelocity_max_deg_s = 60\n"
                       "[joint.wrist.sim]\nstart_rad = 1.2\n",
                       safety);
}

TEST(Home, AJointThatDoesNotFollowOnItsWayToZeroEndsTheRoutineAtOnceAndNotAfterItsMinute)
{
    Rig rig(file_of(servos("policy = \"hold\"")));
    rig.enable();
    rig.inject(sim::FaultKind::stuck_gear, "arm");
    const TimePoint begun = rig.now();
    const auto homed = rig.robot->home();
    EXPECT_NE(said(homed).find("arm: it is at"), std::string::npos) << said(homed);
    EXPECT_NE(said(homed).find("does not follow"), std::string::npos) << said(homed);
    EXPECT_LT(rig.now() - begun, 6s) << "to its lead, a second of patience, and two at most to rest";
    for (const Joint& joint : rig.robot->joints())
        EXPECT_EQ(joint.command().mode, Mode::hold) << joint.name();
    const double rests_at = rig.truth_rad("wrist");
    rig.simulator->clock().wait({}, rig.now() + 2s);
    EXPECT_NEAR(units::deg(rig.truth_rad("wrist")), units::deg(rests_at), 1.0) << "nobody drives any more";
}

/// So viscous that it sinks at 1.6 deg/s under 28 Nm, whatever a servo of 2 Nm does.
config::RobotFile sinking()
{
    auto file = file_of(servos(""));
    for (auto& joint : file.joints)
        joint.plant.push_back({"viscous_friction_nm_s_per_rad", 1000.0, {}});
    return file;
}

void push(Rig& rig, std::string_view joint)
{
    sim::Fault load{.kind = sim::FaultKind::push, .joint = std::string(joint)};
    load.torque_nm = -28.0;
    rig.simulator->world().inject(load);
    ASSERT_EQ(said(rig.run(300ms)), "");
    ASSERT_NEAR(units::deg(rig.truth_rad_s(joint)), -1.6, 0.3);
}

TEST(Home, AJointThatCreepsIsNotSaidToStandStillWhenTheRoutineFails)
{
    Rig rig(sinking());
    rig.enable();
    push(rig, "arm");
    const auto homed = said(rig.robot->home(100ms));
    EXPECT_NE(homed.find("arm was told to hold and was not seen to stand still"), std::string::npos) << homed;
    EXPECT_EQ(homed.find("wrist was told"), std::string::npos) << homed;
}

TEST(Home, AJointThatCreepsIsNotSaidToHaveStopped)
{
    Rig rig(sinking());
    rig.enable();
    push(rig, "arm");
    for (const auto& one : rig.robot->stop()) {
        EXPECT_EQ(one.outcome, one.joint == "arm" ? Stopped::Outcome::failed : Stopped::Outcome::confirmed)
            << one.joint;
        if (one.joint == "arm") {
            EXPECT_EQ(to_sentence(one.why), "arm was told to hold and was not seen to stand still");
        }
    }
}

TEST(Home, AJointThatThePolicyLetGoIsNotSeizedByARoutineThatFails)
{
    for (const auto* policy : {"release", "brake"}) {
        Rig rig(file_of(servos(fmt::format("policy = \"{}\"", policy))));
        rig.enable();
        rig.inject(sim::FaultKind::stuck_gear, "arm");
        EXPECT_NE(said(rig.robot->home()), "");
        EXPECT_EQ(to_word(rig.robot->find("arm")->command().mode), policy);
        EXPECT_EQ(rig.robot->find("wrist")->command().mode, Mode::hold) << "it was on its way";
    }
}

/// Nothing else keeps the routine looking. Whether it is found out after an exchange or before one is chance.
TEST(Home, AJointThatIsStoppedForItsCurrentHearsOfThatBeforeItsRoutineFails)
{
    for (int start_deg = 0; start_deg < 20; ++start_deg) {
        Rig rig(file_of(fmt::format(
            "version = 1\n[safety]\npolicy = \"release\"\non_fault = \"joint\"\n[bus.r]\nfamily = \"rmd\"\n"
            "[joint.knee]\nbus = \"r\"\nid = 1\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\n"
            "current_max_a = 1\nvelocity_max_deg_s = 60\n[joint.knee.home]\nroutine = \"stop\"\ndirection = 1\n"
            "[joint.knee.sim]\nstart_rad = {}\n[joint.knee.plant]\nstop_max_deg = 30\n",
            units::rad(start_deg))));
        rig.enable();
        EXPECT_NE(said(rig.robot->home("knee")), "");
        rig.simulator->clock().wait({}, rig.now() + 500ms);
        EXPECT_NEAR(rig.simulator->world().look("knee")->current_a, 0.0, 0.01) << start_deg;
    }
}

TEST(Home, AJointThatTheProgramReleasedIsNotSeizedByARoutineThatIsRefused)
{
    auto file = file_of(servos(""));
    file.joints[1].position_min_rad = units::rad(30); // 0 is beyond it
    Rig rig(file);
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("wrist", {.mode = Mode::release})), "");
    ASSERT_EQ(said(rig.run(100ms)), "");
    EXPECT_NE(said(rig.robot->home()), "");
    EXPECT_EQ(rig.robot->find("wrist")->command().mode, Mode::release);
    EXPECT_EQ(rig.robot->find("arm")->command().mode, Mode::hold) << "it had been sent to 0";
}

/// An LK motor with a gear, whose stop is not in the first turn that it counts.
constexpr std::string_view lk_knee = R"(
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
position_min_deg = -90
position_max_deg = 200
velocity_max_deg_s = 60
[joint.knee.profile_options]
gear_ratio = 6
[joint.knee.sim]
start_rad = 0.3
[joint.knee.plant]
stop_min_deg = -90
[joint.knee.home]
routine = "stop"
direction = -1
position_deg = -90
velocity_deg_s = 30
)";

constexpr double knee_zero_deg = -90.0 + 6 * 90.0; ///< by the shaft in front of the gear

TEST(Home, AnLkMotorThatFoundItsStopAndIsHeldThereComesToItsZero)
{
    Rig rig(file_of(lk_knee));
    rig.enable();
    ASSERT_EQ(said(rig.robot->home("knee")), "");
    EXPECT_TRUE(rig.robot->find("knee")->referenced());
    EXPECT_NEAR(units::deg(rig.truth_rad("knee")), knee_zero_deg, 0.5);
}

TEST(Home, AnLkMotorThatWasBlockedAndStoppedCountsOnWhereItWas)
{
    Rig rig(file_of(lk_knee));
    rig.enable();
    ASSERT_EQ(said(rig.robot->home("knee")), "");
    rig.inject(sim::FaultKind::stuck_gear, "knee");
    ASSERT_EQ(said(rig.robot->set("knee", {.mode = Mode::position, .position_rad = 2.0, .velocity_rad_s = 0.5})), "");
    ASSERT_EQ(said(rig.run(1500ms)), "");
    const double stands = *rig.robot->find("knee")->state().position_rad;
    ASSERT_EQ(rig.robot->stop().front().outcome, Stopped::Outcome::confirmed);
    rig.enable();
    EXPECT_TRUE(rig.robot->find("knee")->referenced());
    EXPECT_NEAR(*rig.robot->find("knee")->state().position_rad, stands, 0.01);
}

void let_go_of_the_knee(Rig& rig, bool by_stop)
{
    if (by_stop)
        (void)rig.robot->stop();
    else
        ASSERT_EQ(said(rig.robot->set("knee", {.mode = Mode::release})), "");
    (void)rig.run(100ms);
}

TEST(Home, AnLkMotorThatWasReleasedMustBeTakenHomeAgain)
{
    for (const bool by_stop : {false, true}) {
        auto file = file_of(lk_knee);
        if (by_stop)
            file.safety.policy = config::Policy::release;
        Rig rig(file);
        rig.enable();
        ASSERT_EQ(said(rig.robot->home("knee")), "");
        let_go_of_the_knee(rig, by_stop);
        EXPECT_FALSE(rig.robot->find("knee")->referenced()) << by_stop;
        rig.enable();
        ASSERT_EQ(said(rig.robot->home("knee")), "");
        EXPECT_TRUE(rig.robot->find("knee")->referenced());
        EXPECT_NEAR(units::deg(rig.truth_rad("knee")), knee_zero_deg, 0.5);
    }
}

/// Its angle jumps while the shaft turns, so nothing in what it says shows that turns are gone.
TEST(Home, AnLkMotorThatIsReleasedWhileItTurnsMustBeTakenHomeAgain)
{
    for (const bool by_stop : {false, true})
        for (const Duration on_its_way : {200ms, 900ms, 1500ms}) {
            auto file = file_of(lk_knee);
            file.safety.policy = config::Policy::release;
            Rig rig(file);
            rig.enable();
            ASSERT_EQ(said(rig.robot->home("knee")), "");
            ASSERT_EQ(said(rig.robot->set("knee", {.mode = Mode::velocity, .velocity_rad_s = 0.5})), "");
            ASSERT_EQ(said(rig.run(on_its_way)), "");
            ASSERT_TRUE(rig.robot->find("knee")->referenced());
            let_go_of_the_knee(rig, by_stop);
            EXPECT_FALSE(rig.robot->find("knee")->referenced()) << by_stop;
            for (const auto& incident : rig.robot->incidents())
                EXPECT_EQ(incident.says.find("afresh"), std::string::npos) << incident.says;
        }
}

/// By its supply that failed for a moment, or by another program; only where it says that it is tells so.
TEST(Home, ANuriThatCountsFromElsewhereMustBeTakenHomeAgain)
{
    for (const bool is_stopped : {false, true}) {
        Rig rig(file_of(waist(range, "direction = -1\nposition_deg = -90\nvelocity_deg_s = 30",
                              "[joint.waist.plant]\nstop_min_deg = -90\n")));
        rig.enable();
        const Joint& joint = *rig.robot->find("waist");
        ASSERT_EQ(said(rig.robot->home("waist")), "");
        ASSERT_EQ(said(rig.robot->set("waist", {.mode = Mode::position, .position_rad = 1.0, .velocity_rad_s = 0.5})),
                  "");
        ASSERT_EQ(said(rig.run(3s)), "");
        ASSERT_TRUE(joint.referenced());
        if (is_stopped)
            (void)rig.robot->stop();
        bus::Result result;
        const auto reset = *wire::make_request(1, nuri::ResetPosition{});
        ASSERT_TRUE(rig.robot->buses().front()->exchange({&reset, 1}, {&result, 1}));
        for (int i = 0; i < 50; ++i) {
            (void)rig.robot->cycle();
            rig.simulator->clock().wait({}, rig.now() + 10ms);
        }
        EXPECT_FALSE(joint.referenced()) << is_stopped;
        EXPECT_NEAR(units::deg(rig.truth_rad_s("waist")), 0.0, 0.1);
    }
}

TEST(Home, AMotorThatLostItsTurnsWhileTheRobotWasOnlyReadMustBeTakenHomeAgain)
{
    std::string text(lk_knee);
    text.replace(text.find("lk-2.35"), 7, "rmd-2.35");
    Rig rig(file_of(text));
    rig.enable();
    ASSERT_EQ(said(rig.robot->home("knee")), "");
    (void)rig.robot->stop();
    sim::Fault cut{.kind = sim::FaultKind::power_cut, .bus = "r", .for_s = 0.1};
    rig.simulator->world().inject(cut);
    for (int i = 0; i < 100; ++i) {
        (void)rig.robot->cycle();
        rig.simulator->clock().wait({}, rig.now() + 10ms);
    }
    rig.enable();
    EXPECT_FALSE(rig.robot->find("knee")->referenced());
}

/// While another joint is still on its way to its zero, or still looks for its stop; its supply failed for a moment.
TEST(Home, AJointThatStartsAfreshAtItsStopIsNotAtHome)
{
    for (const bool is_search : {false, true}) {
        Rig rig(file_of(
            fmt::format("version = 1\n[safety]\npolicy = \"hold\"\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n"
                        "[joint.waist]\nbus = \"n\"\nid = 1\nposition_min_deg = -10\nposition_max_deg = 200\n"
                        "velocity_max_deg_s = 60\n[joint.waist.sim]\nstart_rad = 0.2\n[joint.waist.plant]\n"
                        "stop_min_deg = -5\n[joint.waist.home]\nroutine = \"stop\"\ndirection = -1\n"
                        "velocity_deg_s = 20\n[joint.neck]\nbus = \"n\"\nid = 2\nposition_min_deg = -10\n"
                        "position_max_deg = 200\nvelocity_max_deg_s = 60\n[joint.neck.sim]\nstart_rad = 2.0\n"
                        "[joint.neck.plant]\nstop_min_deg = -5\n[joint.neck.home]\nvelocity_deg_s = 10\n{}",
                        is_search ? "routine = \"stop\"\ndirection = -1\n" : "")));
        rig.enable();
        bool is_cut = false;
        rig.robot->buses().front()->set_tap([&](const bus::Tapped&) {
            if (is_cut || rig.truth_rad("neck") > 1.0)
                return;
            is_cut = true;
            EXPECT_TRUE(rig.robot->find("waist")->referenced());
            rig.inject(sim::FaultKind::power_cut, "waist", 0.4);
        });
        EXPECT_NE(said(rig.robot->home()), "") << is_search;
        EXPECT_TRUE(is_cut);
        EXPECT_FALSE(rig.robot->find("waist")->referenced()) << is_search;
    }
}

TEST(Home, AJointThatWasReleasedAtItsZeroIsHeldThereWhenItIsAtHome)
{
    Rig rig(file_of("version = 1\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n[joint.neck]\nbus = \"n\"\nid = 1\n"
                    "velocity_max_deg_s = 60\n"));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("neck", {.mode = Mode::release})), "");
    ASSERT_EQ(said(rig.run(1s)), "");
    ASSERT_EQ(rig.simulator->world().look("neck")->mode, "off");
    EXPECT_EQ(said(rig.robot->home()), "");
    EXPECT_EQ(rig.simulator->world().look("neck")->mode, "position");
}

} // namespace
} // namespace sinew::robot::test
