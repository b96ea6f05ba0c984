#include "sinew/sim/firmware/servo.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

void run(Trajectory& trajectory, int steps)
{
    for (int i = 0; i < steps; ++i)
        trajectory.step();
}

int steps_to(Trajectory& trajectory, double target_rad)
{
    int steps = 0;
    while (trajectory.position_rad() != target_rad && ++steps < 100'000)
        trajectory.step();
    return steps;
}

TEST(Trajectory, FollowsATargetInTheTimeOfItsTrapezoid)
{
    Trajectory trajectory;
    trajectory.follow(3.0, 2.0, 10.0);
    // 3 rad / 2 rad/s + 2 rad/s / 10 rad/s² = 1.7 s
    EXPECT_NEAR(steps_to(trajectory, 3.0), 1700, 1);
    EXPECT_EQ(trajectory.position_rad(), 3.0);
}

TEST(Trajectory, TurnsAtTheGivenSpeedBetweenItsRamps)
{
    Trajectory trajectory;
    trajectory.start(-1.0);
    trajectory.follow(-4.0, 2.0, 10.0);
    run(trajectory, 200);
    for (int i = 0; i < 1000; ++i) {
        trajectory.step();
        ASSERT_EQ(trajectory.velocity_rad_s(), -2.0);
    }
}

TEST(Trajectory, NeverPassesTheTargetNorItsLimits)
{
    for (const double target : {1e-6, 0.001, 0.0317, 0.4, 2.71828, 30.0}) {
        Trajectory trajectory;
        trajectory.follow(target, 5.0, 33.0);
        for (int i = 0; i < 10'000; ++i) {
            trajectory.step();
            ASSERT_LE(trajectory.position_rad(), target);
            ASSERT_LE(trajectory.velocity_rad_s(), 5.0);
            ASSERT_LE(std::abs(trajectory.acceleration_rad_s2()), 33.0 * (1 + 1e-9));
        }
        EXPECT_EQ(trajectory.position_rad(), target);
        EXPECT_EQ(trajectory.velocity_rad_s(), 0.0);
    }
}

TEST(Trajectory, ComesBackWhenItCannotStopBeforeTheTarget)
{
    Trajectory trajectory;
    trajectory.turn(8.0, 40.0);
    run(trajectory, 300);
    const double target = trajectory.position_rad() + 0.1;
    trajectory.follow(target, 8.0, 40.0);
    double furthest = 0.0;
    for (int i = 0; i < 2000; ++i) {
        trajectory.step();
        furthest = std::max(furthest, trajectory.position_rad());
    }
    EXPECT_GT(furthest, target + 0.5); // 8² / (2 · 40) = 0.8 rad to stop
    EXPECT_EQ(trajectory.position_rad(), target);
}

TEST(Trajectory, WithoutAccelerationDoesNotMove)
{
    Trajectory trajectory;
    trajectory.follow(1.0, 1.0, 0.0);
    run(trajectory, 1000);
    EXPECT_EQ(trajectory.position_rad(), 0.0);
}

TEST(CruiseVelocity, MakesAMoveTakeTheGivenTime)
{
    Trajectory trajectory;
    const double velocity = cruise_velocity(2.0, 1.5, 20.0);
    EXPECT_NEAR(2.0 / velocity + velocity / 20.0, 1.5, 1e-12);
    trajectory.follow(-2.0, velocity, 20.0);
    EXPECT_NEAR(steps_to(trajectory, -2.0), 1500, 1);
}

TEST(CruiseVelocity, IsThatOfTheFastestMoveWhereTheTimeIsTooShort)
{
    EXPECT_DOUBLE_EQ(cruise_velocity(2.0, 0.01, 20.0), std::sqrt(40.0));
}

/// A motor of 10 N·m and 8 rad/s with 24 V.
PlantParameters motor()
{
    return {.winding_ohm = 6.0,
            .torque_constant_nm_per_a = 0.0285,
            .rotor_inertia_kg_m2 = 1e-5,
            .gear_ratio = 100.0,
            .gear_efficiency = 0.877,
            .coulomb_friction_nm = 0.3,
            .static_friction_nm = 0.4};
}

TEST(Servo, EndsOnTheTargetAgainstFrictionAndWeight)
{
    PlantParameters loaded = motor();
    loaded.gravity_torque_nm = 3.0;
    Plant plant(loaded);
    Servo servo(plant, 24.0);
    servo.follow(1.0, 2.0, 20.0);
    for (int i = 0; i < 3000; ++i) {
        servo.control();
        plant.run(24.0);
    }
    EXPECT_NEAR(plant.position_rad(), 1.0, 1e-4);
    EXPECT_EQ(plant.velocity_rad_s(), 0.0);
}

TEST(Servo, KeepsToTheLimitsOfItsRating)
{
    Plant plant(motor());
    Servo servo(plant, 24.0);
    servo.turn(100.0, 1e9);
    for (int i = 0; i < 1000; ++i) {
        servo.control();
        plant.run(24.0);
    }
    EXPECT_NEAR(plant.velocity_rad_s(), servo.rating().velocity_max_rad_s, 0.01 * servo.rating().velocity_max_rad_s);
}

TEST(Servo, CoastsWhenReleasedAndStopsSoonerWhenBraked)
{
    int ticks[2] = {};
    for (const bool braked : {false, true}) {
        Plant plant(motor());
        Servo servo(plant, 24.0);
        servo.turn(4.0, 40.0);
        for (int i = 0; i < 500; ++i) {
            servo.control();
            plant.run(24.0);
        }
        braked ? servo.brake() : servo.release();
        for (; plant.velocity_rad_s() != 0.0; ++ticks[braked]) {
            servo.control();
            plant.run(24.0);
            ASSERT_EQ(plant.supply_current_a(), 0.0);
        }
    }
    EXPECT_GT(ticks[0], 2 * ticks[1]);
}

} // namespace
} // namespace sinew::sim
