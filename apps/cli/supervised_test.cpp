#include "apps/cli/supervised.hpp"

#include "apps/cli/turning.hpp"
#include "sinew/base/units.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <unistd.h>

namespace sinew::cli {
namespace {

using namespace std::chrono_literals;

/// What a device does not say.
struct Unsaid {
    bool position = false;
    bool anything = false;
};

/// A driver that a test looks on at, and whose device may not say all.
class Observed final : public actuator::Driver
{
public:
    using Look = std::function<void(const actuator::Command&)>;

    Observed(std::unique_ptr<actuator::Driver> driver, Look look, const Unsaid& unsaid)
        : driver_(std::move(driver)), look_(std::move(look)), unsaid_(unsaid)
    {
    }
    const actuator::Capabilities& capabilities() const override { return driver_->capabilities(); }
    std::expected<wire::Requests, Error> plan(const actuator::Command& command, const actuator::State& state) override
    {
        look_(command);
        return driver_->plan(command, state);
    }
    std::expected<wire::Requests, Error> plan_idle() override { return driver_->plan_idle(); }
    std::expected<wire::Requests, Error> plan_read(actuator::Depth depth, double resolution_rad) override
    {
        return driver_->plan_read(depth, resolution_rad);
    }
    std::expected<wire::Requests, Error> plan_cycle(const actuator::Command& command,
                                                    const actuator::State& state) override
    {
        return driver_->plan_cycle(command, state);
    }
    std::expected<void, Error> absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                      actuator::State& state) override
    {
        if (unsaid_.anything)
            return fail(Errc::timeout, "it says nothing");
        auto absorbed = driver_->absorb(asked, reply, at, state);
        if (unsaid_.position)
            state.position_rad = {};
        return absorbed;
    }
    std::expected<wire::Requests, Error> plan_settings() override { return driver_->plan_settings(); }
    std::expected<wire::Requests, Error> plan_reset_check() override { return driver_->plan_reset_check(); }
    std::string_view noticed_reset() const override { return driver_->noticed_reset(); }

private:
    std::unique_ptr<actuator::Driver> driver_;
    Look look_;
    const Unsaid& unsaid_;
};

class SupervisedTest : public testing::Test
{
protected:
    SupervisedTest() { words_.add("--json", ""); }

    /// Tests run in the folder of the sources.
    Driven driven(const std::string& joint, Observed::Look look, const std::string& robot = "robots/demo.toml")
    {
        Words of;
        of.add("TARGET", joint);
        of.add("--robot", robot);
        of.add("--sim", "");
        auto device = target(of);
        auto out = device ? drive_and_read(session_, std::move(*device)) : std::unexpected(device.error());
        EXPECT_TRUE(out) << to_sentence(out.error());
        out->driver = std::make_unique<Observed>(std::move(out->driver), std::move(look), unsaid_);
        return std::move(*out);
    }

    void pass(Duration time)
    {
        for (const TimePoint end = session_.clock().now() + time; session_.clock().now() < end;)
            session_.clock().wait({}, end);
    }

    Session session_;
    Words words_;
    Unsaid unsaid_;
};

TEST_F(SupervisedTest, ALoopThatWasLateDoesNotCatchUpInABurst)
{
    constexpr double speed_rad_s = units::rad(60.0);
    std::vector<std::pair<TimePoint, double>> led;
    auto elbow = driven("elbow", [&](const actuator::Command& command) {
        if (command.mode != actuator::Mode::position)
            return;
        led.emplace_back(session_.clock().now(), *command.position_rad);
        if (led.size() == 5)
            pass(900ms);
    });
    const auto moved =
        move_to(words_, session_, elbow, {.position_rad = units::rad(100.0), .speed_rad_s = speed_rad_s});
    ASSERT_TRUE(moved) << to_sentence(moved.error());
    ASSERT_GT(led.size(), 50U);
    for (std::size_t i = 1; i < led.size(); ++i) {
        const double gap_s = std::min(seconds(led[i].first - led[i - 1].first), 0.05);
        EXPECT_LE(std::abs(led[i].second - led[i - 1].second), speed_rad_s * gap_s + 1e-9) << i; // rounding
    }
}

TEST_F(SupervisedTest, WhatDoesNotSayWhereItIsIsNotTurnedAgainstALimit)
{
    int commands = 0;
    auto hip = driven("left_hip", [&](const actuator::Command&) { ++commands; });
    hip.state.position_rad = {};
    const Turning turning{.mode = actuator::Mode::velocity, .value = 0.3, .time = 60s};
    const auto refused = turn_on(words_, session_, hip, turning);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().detail.find("has not been measured yet"), std::string::npos) << refused.error().detail;
    EXPECT_EQ(commands, 0);
}

TEST_F(SupervisedTest, WhatNoLongerSaysWhereItIsIsStopped)
{
    TimePoint begin{}, end{};
    auto hip = driven("left_hip", [&](const actuator::Command& command) {
        unsaid_.position = command.mode == actuator::Mode::velocity;
        (unsaid_.position ? begin : end) = session_.clock().now();
    });
    const auto ended = turn_on(words_, session_, hip, {.mode = actuator::Mode::velocity, .value = 0.3, .time = 60s});
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, Errc::timeout);
    EXPECT_NE(ended.error().detail.find("left_hip: it answers, but has not told its position for 0.5"),
              std::string::npos)
        << ended.error().detail;
    EXPECT_GT(end, begin);
    EXPECT_LT(end - begin, 700ms); // silence_max_s, and what a look takes
}

/// A robot file with one joint, named joint.
class OneJoint
{
public:
    explicit OneJoint(std::string_view text) { std::ofstream(path_) << "version = 1\n" << text; }
    ~OneJoint() { std::filesystem::remove(path_); }
    OneJoint(const OneJoint&) = delete;
    OneJoint& operator=(const OneJoint&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_ = (std::filesystem::temp_directory_path() / fmt::format("one-{}.toml", ::getpid())).string();
};

constexpr std::string_view rmd_joint = "[bus.b]\nfamily = \"rmd\"\n[joint.joint]\nbus = \"b\"\nid = 1\nmodel = \"MG\"\n"
                                       "profile = \"rmd-2.35\"\n";

TEST_F(SupervisedTest, ACurrentThatIsMoreThanTheGreatestTorqueIsNotSent)
{
    const OneJoint file(fmt::format("{}torque_max_nm = 1\n[joint.joint.profile_options]\n"
                                    "torque_constant_nm_per_a = 2\n",
                                    rmd_joint));
    int commands = 0;
    auto joint = driven("joint", [&](const actuator::Command&) { ++commands; }, file.path());
    const auto refused =
        turn_on(words_, session_, joint, {.mode = actuator::Mode::current, .value = -0.6, .time = 50ms});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().detail, "joint: 0.6 A are 1.2 Nm, more than the 1 Nm allowed");
    EXPECT_EQ(commands, 0);
}

TEST_F(SupervisedTest, WhatTheSupervisorMakesOfACommandIsWhatIsSent)
{
    std::vector<actuator::Command> told;
    auto hip = driven("left_hip", [&](const actuator::Command& command) { told.push_back(command); });
    Supervised supervised(session_, hip);
    ASSERT_TRUE(supervised.send({.mode = actuator::Mode::position, .position_rad = 0.1}));
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NEAR(told.front().velocity_rad_s.value_or(0.0), units::rad(360.0), 1e-9) << "its velocity_max_deg_s";
}

/// Looks for `time` at a device that is moving, and does not answer for `silence` of it.
std::expected<void, Error> look_past(Session& session, Supervised& supervised, Unsaid& unsaid, Duration silence)
{
    std::expected<void, Error> fine;
    const TimePoint begin = session.clock().now();
    for (TimePoint next = begin; fine && next < begin + 1s; next += 20ms) {
        session.clock().wait({}, next);
        unsaid.anything = next - begin >= 200ms && next - begin < 200ms + silence;
        fine = supervised.look();
    }
    unsaid.anything = false;
    return fine;
}

TEST_F(SupervisedTest, AnAnswerThatIsMissingOnceEndsNothing)
{
    for (const auto* name : {"elbow", "waist_yaw", "left_hip"}) {
        auto joint = driven(name, [](const actuator::Command&) {});
        Supervised supervised(session_, joint, Reached::by_a_leap);
        const auto sent = supervised.send(move_to_position(joint, units::rad(4.0)));
        ASSERT_TRUE(sent) << to_sentence(sent.error());
        const auto fine = look_past(session_, supervised, unsaid_, 60ms);
        EXPECT_TRUE(fine) << name << ": " << to_sentence(fine.error());
    }
}

TEST_F(SupervisedTest, WhoIsBackAfterTimeEnoughToLoseItsSupplyIsNotDrivenOn)
{
    auto hip = driven("left_hip", [](const actuator::Command&) {});
    Supervised supervised(session_, hip);
    ASSERT_TRUE(supervised.send(move_to_position(hip, units::rad(4.0))));
    const auto fine = look_past(session_, supervised, unsaid_, 300ms);
    ASSERT_FALSE(fine);
    EXPECT_NE(fine.error().detail.find("left_hip gave no answer for 0.3"), std::string::npos) << fine.error().detail;
}

TEST_F(SupervisedTest, WhoDoesNotAnswerForSilenceMaxIsGivenUp)
{
    auto hip = driven("left_hip", [](const actuator::Command&) {});
    Supervised supervised(session_, hip);
    ASSERT_TRUE(supervised.send(move_to_position(hip, units::rad(4.0))));
    const auto fine = look_past(session_, supervised, unsaid_, 800ms);
    ASSERT_FALSE(fine);
    EXPECT_NE(fine.error().detail.find("it has not answered for 0.5"), std::string::npos) << fine.error().detail;
}

TEST_F(SupervisedTest, ACommandThatNobodyAcknowledgedIsSentAgainWhenTheDeviceAnswers)
{
    auto hip = driven("left_hip", [](const actuator::Command&) {});
    std::vector<std::vector<std::uint8_t>> sent;
    hip.bus->set_tap([&](const bus::Tapped& tapped) {
        if (tapped.direction == wire::Direction::request)
            sent.emplace_back(tapped.bytes.begin(), tapped.bytes.end());
    });
    Supervised supervised(session_, hip);
    unsaid_.anything = true;
    const auto told = supervised.send(move_to_position(hip, units::rad(4.0)));
    EXPECT_TRUE(told) << to_sentence(told.error());
    ASSERT_TRUE(supervised.is_missing());
    ASSERT_FALSE(sent.empty());
    const auto command = sent.back();
    EXPECT_TRUE(supervised.look()) << "and it says nothing yet";
    EXPECT_NE(sent.back(), command);
    unsaid_.anything = false;
    EXPECT_TRUE(supervised.look());
    EXPECT_EQ(sent.back(), command);
    EXPECT_TRUE(supervised.look());
    EXPECT_NE(sent.back(), command) << "once is enough";
}

} // namespace
} // namespace sinew::cli
