#include "sinew/sim/plant/plant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

constexpr Rating rating{
    .velocity_max_rad_s = 8.0, .acceleration_max_rad_s2 = 40.0, .current_max_a = 2.0, .supply_v = 24.0};

void run(Plant& plant, int steps)
{
    for (int i = 0; i < steps; ++i)
        plant.step();
}

int steps_to(Plant& plant, double target_rad)
{
    int steps = 0;
    while (plant.position_rad() != target_rad && ++steps < 100'000)
        plant.step();
    return steps;
}

TEST(Plant, FollowsATargetInTheTimeOfItsTrapezoid)
{
    Plant plant(rating);
    plant.follow(3.0, 2.0, 10.0);
    // 3 rad / 2 rad/s + 2 rad/s / 10 rad/s² = 1.7 s
    EXPECT_NEAR(steps_to(plant, 3.0), 1700, 1);
    EXPECT_EQ(plant.position_rad(), 3.0);
}

TEST(Plant, TurnsAtTheGivenSpeedBetweenItsRamps)
{
    Plant plant(rating, -1.0);
    plant.follow(-4.0, 2.0, 10.0);
    run(plant, 200);
    for (int i = 0; i < 1000; ++i) {
        plant.step();
        ASSERT_EQ(plant.velocity_rad_s(), -2.0);
    }
}

TEST(Plant, NeverPassesTheTargetNorItsLimits)
{
    for (const double target : {1e-6, 0.001, 0.0317, 0.4, 2.71828, 30.0}) {
        Plant plant(rating);
        plant.follow(target, 5.0, 33.0);
        for (int i = 0; i < 10'000; ++i) {
            plant.step();
            ASSERT_LE(plant.position_rad(), target);
            ASSERT_LE(plant.velocity_rad_s(), 5.0);
            ASSERT_LE(std::abs(plant.acceleration_rad_s2()), 33.0 * (1 + 1e-9));
        }
        EXPECT_EQ(plant.position_rad(), target);
        EXPECT_EQ(plant.velocity_rad_s(), 0.0);
    }
}

TEST(Plant, ComesBackWhenItCannotStopBeforeTheTarget)
{
    Plant plant(rating);
    plant.turn(8.0, 40.0);
    run(plant, 300);
    const double target = plant.position_rad() + 0.1;
    plant.follow(target, 8.0, 40.0);
    double furthest = 0.0;
    for (int i = 0; i < 2000; ++i) {
        plant.step();
        furthest = std::max(furthest, plant.position_rad());
    }
    EXPECT_GT(furthest, target + 0.5); // 8² / (2 · 40) = 0.8 rad to stop
    EXPECT_EQ(plant.position_rad(), target);
}

TEST(Plant, CutsLimitsToThoseOfItsRating)
{
    Plant plant(rating);
    plant.turn(100.0, 1e9);
    plant.step();
    EXPECT_DOUBLE_EQ(plant.velocity_rad_s(), 0.04);
    run(plant, 1000);
    EXPECT_EQ(plant.velocity_rad_s(), 8.0);
}

TEST(Plant, CoastsToRestByFrictionAndStopsTenTimesAsFastWhenBraked)
{
    Plant free(rating);
    Plant braked(rating);
    for (Plant* plant : {&free, &braked}) {
        plant->turn(4.0, 40.0);
        run(*plant, 200);
    }
    free.release();
    braked.brake();
    run(free, 990);
    run(braked, 99);
    EXPECT_GT(free.velocity_rad_s(), 0.0);
    EXPECT_GT(braked.velocity_rad_s(), 0.0);
    run(free, 11);
    run(braked, 2);
    EXPECT_EQ(free.velocity_rad_s(), 0.0);
    EXPECT_EQ(braked.velocity_rad_s(), 0.0);
    EXPECT_EQ(free.current_a(), 0.0);
}

TEST(Plant, IsPushedByACurrentLessFrictionUpToItsGreatestSpeed)
{
    Plant plant(rating);
    plant.push(1.0); // half the torque less a tenth: 0.4 · 40 = 16 rad/s²
    run(plant, 100);
    EXPECT_NEAR(plant.velocity_rad_s(), 1.6, 1e-9);
    EXPECT_EQ(plant.current_a(), 1.0);
    run(plant, 1000);
    EXPECT_EQ(plant.velocity_rad_s(), 8.0);
}

TEST(Plant, IsNotMovedByLessTorqueThanFriction)
{
    Plant plant(rating);
    plant.push(0.2);
    run(plant, 1000);
    EXPECT_EQ(plant.position_rad(), 0.0);
    plant.turn(-1.0, 40.0);
    run(plant, 100);
    plant.push(0.1);
    run(plant, 1000);
    EXPECT_EQ(plant.velocity_rad_s(), 0.0);
}

TEST(Plant, DrawsTheCurrentOfItsAccelerationAndFriction)
{
    Plant plant(rating);
    plant.turn(4.0, 20.0);
    run(plant, 100);
    EXPECT_NEAR(plant.current_a(), 2.0 * (0.5 + 0.1), 1e-9);
    run(plant, 500);
    EXPECT_NEAR(plant.current_a(), 2.0 * 0.1, 1e-9);
    EXPECT_EQ(plant.voltage_v(), 24.0);
    EXPECT_EQ(plant.temperature_c(), 25.0);
}

TEST(Plant, WithoutAccelerationDoesNotMove)
{
    Plant plant(rating);
    plant.follow(1.0, 1.0, 0.0);
    run(plant, 1000);
    EXPECT_EQ(plant.position_rad(), 0.0);
}

TEST(CruiseVelocity, MakesAMoveTakeTheGivenTime)
{
    Plant plant(rating);
    const double velocity = cruise_velocity(2.0, 1.5, 20.0);
    EXPECT_NEAR(2.0 / velocity + velocity / 20.0, 1.5, 1e-12);
    plant.follow(-2.0, velocity, 20.0);
    EXPECT_NEAR(steps_to(plant, -2.0), 1500, 1);
}

TEST(CruiseVelocity, IsThatOfTheFastestMoveWhereTheTimeIsTooShort)
{
    EXPECT_DOUBLE_EQ(cruise_velocity(2.0, 0.01, 20.0), std::sqrt(40.0));
}

} // namespace
} // namespace sinew::sim
