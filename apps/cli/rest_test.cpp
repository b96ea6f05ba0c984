#include "apps/cli/home_stop.hpp"

#include "apps/cli/exit_codes.hpp"

#include <csignal>
#include <fmt/format.h>
#include <functional>
#include <future>
#include <gtest/gtest.h>
#include <thread>
#include <unistd.h>

namespace sinew::cli {
namespace {

using namespace std::chrono_literals;

using Plan = std::expected<wire::Requests, Error>;

/// A driver whose holds are what a test makes of them.
class OtherHold final : public actuator::Driver
{
public:
    /// The hold as it should be, and how many were asked for before.
    using Change = std::function<Plan(Plan hold, int before)>;

    OtherHold(std::unique_ptr<actuator::Driver> driver, Change change)
        : driver_(std::move(driver)), change_(std::move(change))
    {
    }
    const actuator::Capabilities& capabilities() const override { return driver_->capabilities(); }
    Plan plan(const actuator::Command& command, const actuator::State& state) override
    {
        auto planned = driver_->plan(command, state);
        return command.mode == actuator::Mode::hold ? change_(std::move(planned), holds_++) : planned;
    }
    Plan plan_read(actuator::Depth depth, double resolution_rad) override
    {
        return driver_->plan_read(depth, resolution_rad);
    }
    Plan plan_cycle(const actuator::Command& command, const actuator::State& state) override
    {
        return driver_->plan_cycle(command, state);
    }
    std::expected<void, Error> absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                      actuator::State& state) override
    {
        return driver_->absorb(asked, reply, at, state);
    }
    Plan plan_settings() override { return driver_->plan_settings(); }
    Plan plan_reset_check() override { return driver_->plan_reset_check(); }
    std::string_view noticed_reset() const override { return driver_->noticed_reset(); }

private:
    std::unique_ptr<actuator::Driver> driver_;
    Change change_;
    int holds_ = 0;
};

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
    /// A joint of the demo robot that turns, with holds of a kind of their own.
    Driven turning(const std::string& joint, OtherHold::Change change)
    {
        Words words;
        words.add("TARGET", joint);
        words.add("--robot", "robots/demo.toml"); // tests run in the folder of the sources
        words.add("--sim", "");
        auto device = target(words);
        auto driven = device ? drive(session, std::move(*device)) : std::unexpected(device.error());
        EXPECT_TRUE(driven) << to_sentence(driven.error());
        driven->driver = std::make_unique<OtherHold>(std::move(driven->driver), std::move(change));
        EXPECT_TRUE(set_up(*driven));
        EXPECT_TRUE(read_state(*driven, actuator::Depth::full));
        const auto turn = driven->driver->plan({.mode = actuator::Mode::velocity, .velocity_rad_s = 0.3}, {});
        EXPECT_TRUE(turn && carry_out(*driven, *turn));
        wait_until(session, session.clock().now() + 1s);
        return std::move(*driven);
    }

    bool is_at_rest(Driven& driven)
    {
        const auto place = [&] { return read_state(driven, actuator::Depth::motion) ? position_of(driven) : NAN; };
        const double before = place();
        wait_until(session, session.clock().now() + 500ms);
        return std::abs(place() - before) < 0.01;
    }

    Session session;
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
        const auto rest = come_to_rest(session, driven);
        ASSERT_TRUE(rest) << joint << ": " << to_sentence(rest.error());
        EXPECT_EQ(*rest, Rest::holds);
        EXPECT_TRUE(is_at_rest(driven)) << joint;

        auto failed = turning(joint, lost_at_first);
        const auto why = held_after(session, failed, {.code = Errc::bad_reply, .detail = "something was wrong"});
        EXPECT_EQ(why.error().detail, "something was wrong") << joint;
        EXPECT_TRUE(is_at_rest(failed)) << joint;
    }
}

TEST_F(RestTest, ASearchForAStopThatFindsNoneEndsAtRest)
{
    auto driven = turning("waist_yaw", lost_at_first);
    auto file = std::make_shared<config::RobotFile>(*driven.device.file);
    auto& joint = file->joints[static_cast<std::size_t>(driven.device.joint - driven.device.file->joints.data())];
    joint.home = {.to_stop = true, .direction = 1, .velocity_rad_s = 0.2};
    driven.device.joint = &joint;
    driven.device.file = file;
    Words words;
    words.add("--json", "");
    const auto found = find_stop(words, session, driven, 500ms);
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().detail.find("has found no stop"), std::string::npos) << found.error().detail;
    EXPECT_TRUE(is_at_rest(driven));
}

TEST_F(RestTest, AMotorThatTurnsOnIsNotSaidToHaveStopped)
{
    auto driven = turning("waist_yaw", lost);
    const auto rest = come_to_rest(session, driven);
    ASSERT_FALSE(rest);
    EXPECT_EQ(rest.error().code, Errc::timeout);
    EXPECT_NE(rest.error().detail.find("not seen to stand still"), std::string::npos) << rest.error().detail;
    const auto why = held_after(session, driven, {.code = Errc::bad_reply, .detail = "something was wrong"});
    EXPECT_EQ(why.error().code, Errc::bad_reply);
    EXPECT_NE(why.error().detail.find("something was wrong; and waist_yaw was told to hold, but was not seen"),
              std::string::npos)
        << why.error().detail;
}

TEST_F(RestTest, WhatOnlyLetGoIsNotSaidToHold)
{
    auto driven = turning("left_hip", refused);
    testing::internal::CaptureStderr();
    const auto stopped = stop_here(session, driven, Otherwise::release);
    const auto said = testing::internal::GetCapturedStderr();
    ASSERT_TRUE(stopped) << to_sentence(stopped.error());
    EXPECT_EQ(*stopped, exit_interrupted);
    EXPECT_EQ(said.find("it holds"), std::string::npos) << said;
    EXPECT_NE(said.find("left_hip took no hold, so its torque is off"), std::string::npos) << said;
    const auto kept = stop_here(session, driven);
    ASSERT_FALSE(kept);
    EXPECT_NE(kept.error().detail.find("did not confirm that it holds"), std::string::npos) << kept.error().detail;
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
    const auto stopped = stop_here(session, driven);
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
    Device on_a_port = driven.device;
    on_a_port.link = "serial:/dev/sinew-is-not-here";
    ASSERT_TRUE(session.guard(on_a_port));
    answer = std::async(std::launch::async, [] { return robot::stop_program(::getpid()); });
    while (!session.guardian()->stop_asked())
        std::this_thread::yield();
    const auto stopped = stop_here(session, driven);
    EXPECT_TRUE(stopped) << to_sentence(stopped.error());
    EXPECT_FALSE(frames_are_out);
    const auto told = answer.get();
    ASSERT_TRUE(told) << to_sentence(told.error());
    EXPECT_TRUE(told->by_guardian);
}

} // namespace
} // namespace sinew::cli
