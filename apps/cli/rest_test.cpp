#include "apps/cli/home_stop.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/moving.hpp"
#include "apps/cli/stopping.hpp"
#include "apps/cli/turning.hpp"

#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <future>
#include <gtest/gtest.h>
#include <thread>
#include <unistd.h>

namespace sinew::cli {
namespace {

using namespace std::chrono_literals;

using Plan = std::expected<wire::Requests, Error>;

/// What cannot be seen of a device, from now on.
struct Hidden {
    int looks = 0;                              ///< that are answered by nothing that counts
    int positions = 0;                          ///< that an answer does not say
    std::function<double(TimePoint)> place_rad; ///< of the actuator, where that is another than it has
};

/// Whether there was one left.
bool take_one(int& left)
{
    if (left == 0)
        return false;
    --left;
    return true;
}

/// A driver whose holds and looks are what a test makes of them.
class OtherHold final : public actuator::Driver
{
public:
    /// The hold as it should be, and how many were asked for before.
    using Change = std::function<Plan(Plan hold, int before)>;

    OtherHold(std::unique_ptr<actuator::Driver> driver, Change change, Hidden& hidden)
        : driver_(std::move(driver)), change_(std::move(change)), hidden_(hidden)
    {
    }
    const actuator::Capabilities& capabilities() const override { return driver_->capabilities(); }
    Plan plan(const actuator::Command& command, const actuator::State& state) override
    {
        auto planned = driver_->plan(command, state);
        return command.mode == actuator::Mode::hold ? change_(std::move(planned), holds_++) : planned;
    }
    Plan plan_idle() override { return driver_->plan_idle(); }
    Plan plan_read(actuator::Depth depth, double resolution_rad) override
    {
        hides_look_ = take_one(hidden_.looks);
        hides_position_ = take_one(hidden_.positions);
        return driver_->plan_read(depth, resolution_rad);
    }
    Plan plan_cycle(const actuator::Command& command, const actuator::State& state) override
    {
        return driver_->plan_cycle(command, state);
    }
    std::expected<void, Error> absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                      actuator::State& state) override
    {
        if (hides_look_)
            return fail(Errc::timeout, "it says nothing");
        auto absorbed = driver_->absorb(asked, reply, at, state);
        if (hides_position_)
            state.position_rad = {};
        else if (hidden_.place_rad && state.position_rad)
            state.position_rad = {hidden_.place_rad(at), at};
        return absorbed;
    }
    Plan plan_settings() override { return driver_->plan_settings(); }
    Plan plan_reset_check() override { return driver_->plan_reset_check(); }
    std::string_view noticed_reset() const override { return driver_->noticed_reset(); }

private:
    std::unique_ptr<actuator::Driver> driver_;
    Change change_;
    Hidden& hidden_;
    int holds_ = 0;
    bool hides_look_ = false, hides_position_ = false;
};

Plan as_it_is(Plan hold, int)
{
    return hold;
}

/// Never on the wire, and nobody notices.
Plan lost(const Plan&, int)
{
    return wire::Requests{};
}

Plan refused(const Plan&, int)
{
    return fail(Errc::unsupported, "this one cannot hold");
}

class RestTest : public testing::Test
{
protected:
    RestTest() { words_.add("--json", ""); }

    /// A joint of the demo robot that turns, with holds of a kind of their own.
    Driven turning(const std::string& joint, OtherHold::Change change)
    {
        Words of;
        of.add("TARGET", joint);
        of.add("--robot", "robots/demo.toml"); // tests run in the folder of the sources
        of.add("--sim", "");
        auto device = target(of);
        auto driven = device ? drive(session_, std::move(*device)) : std::unexpected(device.error());
        EXPECT_TRUE(driven) << to_sentence(driven.error());
        driven->driver = std::make_unique<OtherHold>(std::move(driven->driver), std::move(change), hidden_);
        EXPECT_TRUE(set_up(*driven));
        EXPECT_TRUE(read_state(*driven, actuator::Depth::full));
        const auto turn = driven->driver->plan({.mode = actuator::Mode::velocity, .velocity_rad_s = 0.3}, {});
        EXPECT_TRUE(turn && carry_out(*driven, *turn));
        wait_until(session_, session_.clock().now() + 1s);
        return std::move(*driven);
    }

    bool is_at_rest(Driven& driven)
    {
        const auto place = [&] {
            return read_state(driven, actuator::Depth::motion) ? position_of(driven).value_or(NAN) : NAN;
        };
        const double before = place();
        wait_until(session_, session_.clock().now() + 500ms);
        return std::abs(place() - before) < 0.01;
    }

    /// What the robot file says of it, for this test alone.
    static config::Joint& joint_of(Driven& driven)
    {
        auto file = std::make_shared<config::RobotFile>(*driven.device.file);
        auto& joint = file->joints[static_cast<std::size_t>(driven.device.joint - driven.device.file->joints.data())];
        driven.device.joint = &joint;
        driven.device.file = file;
        return joint;
    }

    /// A guardian that reaches no bus, so that only its answer counts.
    void guard(const Driven& driven)
    {
        Device on_a_port = driven.device;
        on_a_port.link = "serial:/dev/sinew-is-not-here";
        ASSERT_TRUE(session_.guard(on_a_port));
    }

    /// Returns when it is asked for, not when it is answered.
    std::future<std::expected<robot::StoppedProgram, Error>> ask_for_a_stop()
    {
        auto answer = std::async(std::launch::async, [] { return robot::stop_program(::getpid()); });
        while (!session_.guardian()->stop_asked())
            std::this_thread::yield();
        return answer;
    }

    Hidden hidden_;
    Session session_;
    Words words_; ///< of the verb
};

/// The first telling is lost, and those of the second look as well.
Plan lost_at_first(Plan hold, int before)
{
    return before < 2 ? wire::Requests{} : std::move(hold);
}

TEST_F(RestTest, WhateverEndsAMotionIsToldAgainUntilTheMotorIsSeenAtRest)
{
    for (const auto* joint : {"waist_yaw", "left_hip"}) {
        auto driven = turning(joint, lost_at_first);
        const auto rest = come_to_rest(session_, driven);
        ASSERT_TRUE(rest) << joint << ": " << to_sentence(rest.error());
        EXPECT_EQ(*rest, Rest::holds);
        EXPECT_TRUE(is_at_rest(driven)) << joint;

        auto failed = turning(joint, lost_at_first);
        const auto why = held_after(session_, failed, {.code = Errc::bad_reply, .detail = "something was wrong"});
        EXPECT_EQ(why.error().detail, "something was wrong; it is held at " + place_of(failed));
        EXPECT_TRUE(is_at_rest(failed)) << joint;
    }
}

TEST_F(RestTest, ASearchForAStopThatFindsNoneEndsAtRest)
{
    auto driven = turning("waist_yaw", lost_at_first);
    joint_of(driven).home = {.to_stop = true, .direction = 1, .velocity_rad_s = 0.2, .travel_max_rad = 0.3};
    const auto found = find_stop(words_, session_, driven);
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().detail.find("as far as it may for its stop, 17 deg, and found none"), std::string::npos)
        << found.error().detail;
    EXPECT_TRUE(is_at_rest(driven));
}

TEST_F(RestTest, AStopThatFailedIsNotTriedOnceMoreNorToldTwice)
{
    int holds = 0;
    auto driven = turning("left_hip", [&](const Plan&, int before) {
        holds = before + 1;
        return refused({}, before);
    });
    const auto refusal = come_to_rest(session_, driven);
    ASSERT_FALSE(refusal);
    const int holds_of_one_stop = holds;
    (void)std::raise(SIGINT);
    const auto moved = move_to(words_, session_, driven, {.position_rad = 0.3});
    clear_interrupt();
    ASSERT_FALSE(moved);
    EXPECT_EQ(moved.error().detail, refusal.error().detail);
    EXPECT_EQ(holds, 2 * holds_of_one_stop);
}

TEST_F(RestTest, AMoveWhoseLooksFailComesToRest)
{
    for (const auto* joint : {"waist_yaw", "elbow", "left_hip"}) {
        auto driven = turning(joint, as_it_is);
        ASSERT_TRUE(read_state(driven, actuator::Depth::full));
        hidden_.looks = 30; // of 20 ms each: more than silence_max_s
        const auto moved = move_to(words_, session_, driven, {.position_rad = 0.5, .speed_rad_s = 0.1});
        ASSERT_FALSE(moved) << joint;
        EXPECT_NE(moved.error().detail.find("has not answered for 0.5"), std::string::npos) << moved.error().detail;
        EXPECT_TRUE(is_at_rest(driven)) << joint;
    }
}

TEST_F(RestTest, AMoveThatTakesTooLongComesToRest)
{
    for (const auto* joint : {"waist_yaw", "left_hip"}) {
        auto driven = turning(joint, as_it_is);
        ASSERT_TRUE(read_state(driven, actuator::Depth::full));
        const auto moved = move_to(words_, session_, driven, {.position_rad = 0.5, .speed_rad_s = 0.1, .limit = 200ms});
        ASSERT_FALSE(moved) << joint;
        EXPECT_NE(moved.error().detail.find("--within"), std::string::npos) << moved.error().detail;
        EXPECT_TRUE(is_at_rest(driven)) << joint;
    }
}

TEST_F(RestTest, ALimitIsToldAlsoWhereTheMotorTurnsOn)
{
    auto driven = turning("waist_yaw", lost);
    joint_of(driven).position_max_rad = 0.5;
    const auto ended = turn_on(words_, session_, driven,
                               {.mode = actuator::Mode::velocity, .value = 0.3, .time = std::chrono::seconds(5)});
    ASSERT_FALSE(ended);
    for (const auto* part : {"waist_yaw: it has come to its limit of 28.65 deg", "not seen to stand still"})
        EXPECT_NE(ended.error().detail.find(part), std::string::npos) << ended.error().detail;
}

TEST_F(RestTest, AMotorThatTurnsOnIsNotSaidToHaveStopped)
{
    auto driven = turning("waist_yaw", lost);
    const auto rest = come_to_rest(session_, driven);
    ASSERT_FALSE(rest);
    EXPECT_EQ(rest.error().code, Errc::timeout);
    EXPECT_NE(rest.error().detail.find("not seen to stand still"), std::string::npos) << rest.error().detail;
    const auto why = held_after(session_, driven, {.code = Errc::bad_reply, .detail = "something was wrong"});
    EXPECT_EQ(why.error().code, Errc::bad_reply);
    EXPECT_NE(why.error().detail.find("something was wrong; and waist_yaw was told to hold, but was not seen"),
              std::string::npos)
        << why.error().detail;
}

TEST_F(RestTest, AMotorThatCreepsIsNotSaidToHold)
{
    auto driven = turning("wrist_pitch", as_it_is);
    // From one look to the next it is one step of its position, or two.
    const double step = driven.driver->capabilities().position_step_rad;
    hidden_.place_rad = [&](TimePoint at) {
        return step * std::round(units::rad(1.2) * seconds(at.time_since_epoch()) / step);
    };
    const auto rest = come_to_rest(session_, driven);
    ASSERT_FALSE(rest);
    EXPECT_NE(rest.error().detail.find("wrist_pitch was told to hold, but was not seen to stand still"),
              std::string::npos)
        << rest.error().detail;
}

TEST_F(RestTest, AMotorWhosePositionFlickersHolds)
{
    auto driven = turning("wrist_pitch", as_it_is);
    bool odd = false;
    hidden_.place_rad = [&](TimePoint) {
        odd = !odd;
        return odd ? driven.driver->capabilities().position_step_rad : 0.0;
    };
    const auto rest = come_to_rest(session_, driven);
    EXPECT_TRUE(rest) << to_sentence(rest.error());
}

TEST_F(RestTest, WhatOnlyLetGoIsNotSaidToHold)
{
    auto driven = turning("left_hip", refused);
    testing::internal::CaptureStderr();
    const auto stopped = stop_here(session_, driven, Otherwise::release);
    const auto said = testing::internal::GetCapturedStderr();
    ASSERT_TRUE(stopped) << to_sentence(stopped.error());
    EXPECT_EQ(*stopped, exit_interrupted);
    EXPECT_EQ(said.find("it holds"), std::string::npos) << said;
    EXPECT_NE(said.find("left_hip took no hold, so its torque is off"), std::string::npos) << said;
    const auto kept = stop_here(session_, driven);
    ASSERT_FALSE(kept);
    EXPECT_NE(kept.error().detail.find("was told to hold and did not confirm that"), std::string::npos)
        << kept.error().detail;
}

TEST_F(RestTest, ACtrlCThatComesWhileItIsToldAgainIsNotSwallowed)
{
    int holds = 0;
    auto driven = turning("waist_yaw", [&](const Plan&, int before) -> Plan {
        holds = before + 1;
        if (holds == 2)
            (void)std::raise(SIGINT);
        return wire::Requests{};
    });
    (void)std::raise(SIGINT);
    const auto stopped = stop_here(session_, driven);
    ASSERT_TRUE(stopped) << to_sentence(stopped.error());
    EXPECT_EQ(*stopped, exit_interrupted);
    EXPECT_EQ(holds, 2) << "it was told on and on";
    clear_interrupt();
}

/// Who asked for the stop is not answered before the device was told: as long as nothing is out the guardian does it.
TEST_F(RestTest, AStopIsNotCalledBegunBeforeItsFramesAreOut)
{
    std::future<std::expected<robot::StoppedProgram, Error>> answer;
    bool frames_are_out = false;
    auto driven = turning("left_hip", [&](Plan hold, int before) {
        // The device that does not come to be told: until somebody else has done it.
        if (before == 0)
            frames_are_out = answer.wait_for(60s) != std::future_status::ready;
        return hold;
    });
    guard(driven);
    answer = ask_for_a_stop();
    const auto stopped = stop_here(session_, driven);
    EXPECT_TRUE(stopped) << to_sentence(stopped.error());
    EXPECT_FALSE(frames_are_out);
    const auto told = answer.get();
    ASSERT_TRUE(told) << to_sentence(told.error());
    EXPECT_TRUE(told->by_guardian);
}

TEST_F(RestTest, AHoldThatWasRefusedIsNotAStopThatWasObeyed)
{
    auto driven = turning("left_hip", refused);
    guard(driven);
    auto answer = ask_for_a_stop();
    EXPECT_FALSE(stop_here(session_, driven));
    const auto told = answer.get();
    ASSERT_TRUE(told) << to_sentence(told.error());
    EXPECT_TRUE(told->by_guardian);
}

/// The line is being read then, and frames of the guardian would spoil what is read.
TEST_F(RestTest, AStopThatIsAskedForWhileTheMotorIsLookedAtIsObeyedByTheProgram)
{
    constexpr auto until_the_guardian_does_it = 400ms; // 0.2 s, and the time to do it
    std::future<std::expected<robot::StoppedProgram, Error>> answer;
    bool by_program = false;
    auto driven = turning("waist_yaw", [&](const Plan&, int before) -> Plan {
        if (before == 1)
            answer = ask_for_a_stop();
        if (before == 2)
            by_program = answer.wait_for(until_the_guardian_does_it) != std::future_status::ready;
        return wire::Requests{};
    });
    guard(driven);
    (void)stop_here(session_, driven);
    EXPECT_TRUE(by_program);
    const auto told = answer.get();
    ASSERT_TRUE(told) << to_sentence(told.error());
    EXPECT_FALSE(told->by_guardian);
}

TEST_F(RestTest, AMotorThatCannotSayWhereItIsToHoldIsBraked)
{
    auto mute = turning("elbow", as_it_is);
    hidden_.looks = 1'000'000;
    const auto rest = come_to_rest(session_, mute);
    hidden_.looks = 0;
    ASSERT_FALSE(rest);
    EXPECT_NE(rest.error().detail.find("elbow was told to brake, but was not seen to stand still"), std::string::npos)
        << rest.error().detail;
    EXPECT_TRUE(is_at_rest(mute));

    auto silent_for_a_while = turning("elbow", as_it_is);
    hidden_.looks = 3;
    const auto held = come_to_rest(session_, silent_for_a_while);
    ASSERT_TRUE(held) << to_sentence(held.error());
    EXPECT_EQ(*held, Rest::holds);
}

TEST_F(RestTest, ACtrlCThatNobodyHasSeenYetIsStillThereWhenTheMotorIsAtRest)
{
    auto driven = turning("waist_yaw", as_it_is);
    (void)std::raise(SIGINT);
    EXPECT_TRUE(come_to_rest(session_, driven));
    EXPECT_TRUE(interrupted());
    (void)held_after(session_, driven, {.code = Errc::bad_reply, .detail = "something was wrong"});
    EXPECT_TRUE(interrupted());
    EXPECT_TRUE(let_go(driven));
    EXPECT_TRUE(interrupted());
    clear_interrupt();
}

/// As a Nuri says none for one look when it goes beyond what its feedback can tell.
TEST_F(RestTest, APlaceThatWasNotMeasuredIsNotTakenForZero)
{
    auto driven = turning("waist_yaw", as_it_is);
    ASSERT_TRUE(come_to_rest(session_, driven));
    hidden_.positions = 20;
    testing::internal::CaptureStdout();
    const auto moved = move_to(words_, session_, driven, {.position_rad = 0.0, .speed_rad_s = 0.2});
    (void)testing::internal::GetCapturedStdout();
    ASSERT_TRUE(moved) << to_sentence(moved.error());
    hidden_.positions = 0;
    ASSERT_TRUE(read_state(driven, actuator::Depth::motion));
    ASSERT_TRUE(position_of(driven));
    EXPECT_NEAR(*position_of(driven), 0.0, 0.01); // half a degree
}

} // namespace
} // namespace sinew::cli
