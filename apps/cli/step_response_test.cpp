#include "apps/cli/step_response.hpp"

#include "sinew/base/units.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace sinew::cli {
namespace {

using namespace std::chrono_literals;

/// Samples of a position over time, a millisecond apart.
template <class Position>
std::vector<StepSample> samples_of(double length_s, Position position)
{
    std::vector<StepSample> out;
    for (int i = 0; i <= static_cast<int>(length_s * 1000.0); ++i)
        out.push_back({.time_s = i * 1e-3, .position_rad = position(i * 1e-3), .current_a = i == 10 ? -3.0 : 1.0});
    return out;
}

TEST(StepFigures, OfAFirstOrderSystemAreThoseOfTheTextbook)
{
    const double tau = 0.1;
    const auto figures = figures_of(samples_of(2.0, [&](double t) { return 1.0 - std::exp(-t / tau); }), 1.0);
    EXPECT_NEAR(*figures.rise_time_s, tau * std::log(9.0), 0.002);
    EXPECT_NEAR(*figures.settling_time_s, tau * std::log(50.0), 0.002);
    EXPECT_EQ(figures.overshoot, 0.0);
    EXPECT_NEAR(figures.steady_error_rad, 0.0, 1e-6);
    EXPECT_EQ(figures.peak_current_a, 3.0) << "of either sign";
}

TEST(StepFigures, OfADampedSwingGiveItsOvershootInEitherDirection)
{
    const double damping = 0.2, omega = 20.0;
    const double swing = omega * std::sqrt(1.0 - damping * damping);
    for (const double target : {2.0, -2.0}) {
        const auto figures = figures_of(
            samples_of(3.0,
                       [&](double t) {
                           return target *
                                  (1.0 - std::exp(-damping * omega * t) *
                                             (std::cos(swing * t) + damping * omega / swing * std::sin(swing * t)));
                       }),
            target);
        EXPECT_NEAR(figures.overshoot, std::exp(-std::numbers::pi * damping / std::sqrt(1.0 - damping * damping)),
                    1e-3);
        EXPECT_NEAR(*figures.settling_time_s, 4.0 / (damping * omega), 0.1);
    }
}

TEST(StepFigures, OfWhatStaysOffTheTargetNeverSettle)
{
    const auto figures = figures_of(samples_of(1.0, [](double t) { return t < 0.1 ? 0.0 : 0.85; }), 1.0);
    EXPECT_FALSE(figures.rise_time_s.has_value());
    EXPECT_FALSE(figures.settling_time_s.has_value());
    EXPECT_NEAR(figures.steady_error_rad, 0.15, 1e-9);
}

config::RobotFile arm()
{
    auto file = config::parse_robot_file(R"(
version = 1
[bus.left]
family = "sam"
[bus.legs]
family = "rmd"
[joint.elbow]
bus = "left"
id = 3
model = "SAM-160EO200"
direction = -1
zero_deg = 10
ratio = 2
position_max_deg = 80
[joint.knee]
bus = "legs"
id = 1
)",
                                         "arm.toml");
    EXPECT_TRUE(file.has_value()) << to_sentence(file.error());
    return *file;
}

TEST(StepResponse, BeginsWhereItIsToldAndGoesToTheTargetInJointUnits)
{
    const auto samples =
        step_response(arm(), {.joint = "elbow", .to_rad = units::rad(30), .from_rad = units::rad(-20), .length = 2s});
    ASSERT_TRUE(samples) << to_sentence(samples.error());
    ASSERT_EQ(samples->size(), 2001U);
    EXPECT_NEAR(samples->front().position_rad, units::rad(-20), 1e-9);
    EXPECT_NEAR(samples->back().position_rad, units::rad(30), units::rad(0.1));
    EXPECT_EQ(samples->back().time_s, 2.0);
    double way = 0.0;
    for (const auto& sample : *samples)
        way += sample.velocity_rad_s * 1e-3;
    EXPECT_NEAR(way, units::rad(50), units::rad(1)) << "the velocity is that of the position";
}

TEST(StepResponse, IsTheSameEveryTime)
{
    const StepRequest request{.joint = "elbow", .to_rad = 0.5, .length = 300ms, .gains = {{50, 0, 10}}};
    const auto one = step_response(arm(), request);
    const auto other = step_response(arm(), request);
    ASSERT_TRUE(one && other);
    ASSERT_EQ(one->size(), other->size());
    for (std::size_t i = 0; i < one->size(); ++i)
        EXPECT_EQ((*one)[i].position_rad, (*other)[i].position_rad) << i;
}

TEST(StepResponse, WithLessOfThePGainIsSlower)
{
    const auto quick = step_response(arm(), {.joint = "elbow", .to_rad = 0.5, .length = 1s, .gains = {{100, 0, 100}}});
    const auto slow = step_response(arm(), {.joint = "elbow", .to_rad = 0.5, .length = 1s, .gains = {{10, 0, 100}}});
    ASSERT_TRUE(quick && slow);
    EXPECT_GT((*quick)[100].position_rad, 1.5 * (*slow)[100].position_rad);
}

TEST(StepResponse, RefusesWhatCannotBeDone)
{
    const auto refused = [](StepRequest request) {
        request.length = 10ms;
        const auto samples = step_response(arm(), request);
        return samples ? std::string() : to_sentence(samples.error());
    };
    EXPECT_NE(refused({.joint = "elbo", .to_rad = 1.0}).find("did you mean elbow?"), std::string::npos);
    EXPECT_NE(refused({.joint = "elbow", .to_rad = 2.0}).find("position_max_deg"), std::string::npos);
    EXPECT_NE(refused({.joint = "elbow", .to_rad = 1.0, .from_rad = 2.0}).find("position_max_deg"), std::string::npos);
    EXPECT_NE(refused({.joint = "knee", .to_rad = 1.0, .gains = {{1, 2, 3}}}).find("SAM"), std::string::npos);
    EXPECT_NE(refused({.joint = "elbow", .to_rad = -3.0}), "") << "further than the sensor can tell";
}

} // namespace
} // namespace sinew::cli
