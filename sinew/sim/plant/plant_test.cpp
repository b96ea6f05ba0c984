#include "sinew/sim/plant/plant.hpp"

#include "sinew/sim/plant/supply.hpp"
#include "tests/support/allocations.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace sinew::sim {
namespace {

constexpr double gravity_m_s2 = 9.81;
constexpr double supply_v = 24.0;

/// 12.3 N·m at 4 A and about 7 rad/s without a load, from 24 V.
PlantParameters geared()
{
    return {.winding_ohm = 6.0,
            .torque_constant_nm_per_a = 0.0342,
            .rotor_inertia_kg_m2 = 4e-6,
            .gear_ratio = 100.0,
            .gear_efficiency = 0.9};
}

/// Turns freely and weighs nothing by itself.
PlantParameters free_shaft()
{
    PlantParameters out = geared();
    out.rotor_inertia_kg_m2 = 0.0;
    return out;
}

void run(Plant& plant, double time_s, double voltage_v = supply_v)
{
    for (auto ticks = std::lround(time_s / tick_s); ticks > 0; --ticks)
        plant.run(voltage_v);
}

/// Within one per cent.
void expect_near(double value, double truth)
{
    EXPECT_NEAR(value, truth, std::abs(truth) * 0.01);
}

TEST(Plant, TurnsWithoutALoadAtTheSpeedWhereBackEmfAndFrictionTakeTheWholeVoltage)
{
    PlantParameters p = geared();
    p.viscous_friction_nm_s_per_rad = 0.05;
    p.coulomb_friction_nm = 0.3;
    p.static_friction_nm = 0.4;
    Plant plant(p);
    plant.drive_duty(0.8);
    run(plant, 3.0);
    // u = K·w + R·i and i = (c + b·w) / g
    const double k = p.voltage_constant_v_s_per_rad();
    const double g = p.torque_per_ampere_nm();
    const double speed = (0.8 * supply_v - p.winding_ohm * p.coulomb_friction_nm / g) /
                         (k + p.winding_ohm * p.viscous_friction_nm_s_per_rad / g);
    expect_near(plant.velocity_rad_s(), speed);
    expect_near(plant.current_a(), (p.coulomb_friction_nm + p.viscous_friction_nm_s_per_rad * speed) / g);
}

TEST(Plant, StalledTakesVoltageOverResistanceAndPushesWithAllItsTorque)
{
    PlantParameters p = geared();
    p.stop_max_rad = 0.1;
    Plant plant(p);
    plant.drive_duty(1.0);
    run(plant, 1.0);
    EXPECT_EQ(plant.position_rad(), 0.1);
    expect_near(plant.current_a(), supply_v / p.winding_ohm);
    expect_near(plant.supply_current_a(), supply_v / p.winding_ohm);
    // Against just less than this torque it turns back off the stop, against just more it does not.
    const double stall_nm = p.torque_per_ampere_nm() * supply_v / p.winding_ohm;
    plant.push(-0.99 * stall_nm);
    run(plant, 0.1);
    EXPECT_EQ(plant.position_rad(), 0.1);
    plant.push(-1.01 * stall_nm);
    run(plant, 0.1);
    EXPECT_LT(plant.position_rad(), 0.1);
}

TEST(Plant, SpeedsUpWithItsMechanicalTimeConstant)
{
    const PlantParameters p = geared();
    Plant plant(p);
    plant.drive_duty(1.0);
    const double k = p.voltage_constant_v_s_per_rad();
    const double time_constant_s = p.inertia_kg_m2() * p.winding_ohm / (k * p.torque_per_ampere_nm());
    const double ticks = std::round(time_constant_s / tick_s);
    run(plant, ticks * tick_s);
    expect_near(plant.velocity_rad_s(), supply_v / k * (1.0 - std::exp(-ticks * tick_s / time_constant_s)));
}

TEST(Plant, SwingsAsAPendulumWithThePeriodOfItsLength)
{
    PlantParameters p = free_shaft();
    const double length_m = 0.4;
    const double mass_kg = 2.0;
    p.load_inertia_kg_m2 = mass_kg * length_m * length_m;
    p.gravity_torque_nm = mass_kg * gravity_m_s2 * length_m;
    const double start_rad = 0.05;
    Plant plant(p, start_rad);
    // Ten periods between crossings of the lowest point upwards.
    int crossings = 0;
    double first_s = 0.0;
    double last_s = 0.0;
    for (int i = 0; crossings < 11; ++i) {
        const double before = plant.position_rad();
        plant.run(supply_v);
        if (before < 0.0 && plant.position_rad() >= 0.0) {
            (crossings == 0 ? first_s : last_s) = i * tick_s;
            ++crossings;
        }
    }
    const double period_s = 2.0 * std::numbers::pi * std::sqrt(length_m / gravity_m_s2);
    expect_near((last_s - first_s) / 10.0, period_s * (1.0 + start_rad * start_rad / 16.0));
}

TEST(Plant, PendulumWithoutFrictionKeepsItsEnergyForAMinute)
{
    PlantParameters p = free_shaft();
    p.load_inertia_kg_m2 = 0.32;
    p.gravity_torque_nm = 7.85;
    Plant plant(p, 2.5);
    const double whole = p.gravity_torque_nm * (1.0 - std::cos(2.5));
    double furthest = 0.0;
    for (int i = 0; i < 60'000; ++i) {
        plant.run(supply_v);
        const double v = plant.velocity_rad_s();
        const double energy =
            0.5 * p.inertia_kg_m2() * v * v + p.gravity_torque_nm * (1.0 - std::cos(plant.position_rad()));
        furthest = std::max(furthest, std::abs(energy / whole - 1.0));
    }
    EXPECT_LT(furthest, 0.01);
}

TEST(Plant, TheElectricEnergyIsFoundAgainAsMotionLiftHeatAndFriction)
{
    PlantParameters p = geared();
    p.load_inertia_kg_m2 = 0.2;
    p.gravity_torque_nm = 4.0;
    p.coulomb_friction_nm = 0.3;
    p.static_friction_nm = 0.4;
    p.viscous_friction_nm_s_per_rad = 0.05;
    p.gear_efficiency = 0.8;
    Plant plant(p);
    plant.drive_duty(0.9);
    double electric = 0.0, copper = 0.0, gear = 0.0, friction = 0.0;
    for (int i = 0; i < 300; ++i) {
        const double before_rad = plant.position_rad();
        plant.run(supply_v);
        const double turned_rad = plant.position_rad() - before_rad;
        const double a = plant.current_a();
        electric += supply_v * plant.supply_current_a() * tick_s;
        copper += a * a * p.winding_ohm * tick_s;
        gear += (1.0 - p.gear_efficiency) * p.voltage_constant_v_s_per_rad() * a * turned_rad;
        friction += (p.coulomb_friction_nm + p.viscous_friction_nm_s_per_rad * turned_rad / tick_s) * turned_rad;
    }
    const double v = plant.velocity_rad_s();
    const double motion = 0.5 * p.inertia_kg_m2() * v * v;
    const double lift = p.gravity_torque_nm * (1.0 - std::cos(plant.position_rad()));
    expect_near(motion + lift + copper + gear + friction, electric);
}

TEST(Plant, StaysWhereItIsUntilMoreThanTheStaticFrictionPushes)
{
    PlantParameters p = geared();
    p.coulomb_friction_nm = 0.3;
    p.static_friction_nm = 0.4;
    Plant plant(p);
    plant.push(0.399);
    run(plant, 10.0);
    EXPECT_EQ(plant.position_rad(), 0.0);
    plant.push(0.401);
    run(plant, 0.1);
    EXPECT_GT(plant.velocity_rad_s(), 0.0);
    // Once it turns, less keeps it turning; with less than the Coulomb friction it comes to rest for good.
    plant.push(0.35);
    run(plant, 1.0);
    EXPECT_GT(plant.velocity_rad_s(), 0.0);
    plant.push(0.29);
    run(plant, 60.0);
    EXPECT_EQ(plant.velocity_rad_s(), 0.0);
}

TEST(Plant, ShortedItBrakesByItsOwnCurrentAndTakesNothingFromTheSupply)
{
    const PlantParameters p = geared();
    Plant coasting(p);
    Plant shorted(p);
    for (Plant* plant : {&coasting, &shorted}) {
        plant->drive_duty(1.0);
        run(*plant, 1.0);
    }
    const double speed = coasting.velocity_rad_s();
    coasting.open();
    shorted.short_circuit();
    run(coasting, 0.02);
    run(shorted, 0.02);
    EXPECT_EQ(coasting.velocity_rad_s(), speed);
    // Driven back, the gearbox helps to brake: J·w' = -K² / (R·efficiency)·w
    const double k = p.voltage_constant_v_s_per_rad();
    const double time_constant_s = p.inertia_kg_m2() * p.winding_ohm * p.gear_efficiency / (k * k);
    EXPECT_NEAR(shorted.velocity_rad_s(), speed * std::exp(-0.02 / time_constant_s), 0.01 * speed);
    EXPECT_LT(shorted.current_a(), 0.0);
    EXPECT_EQ(shorted.supply_current_a(), 0.0);
}

TEST(Plant, NeverPassesAHardStop)
{
    PlantParameters p = geared();
    p.stop_min_rad = -0.5;
    p.stop_max_rad = 0.5;
    Plant plant(p);
    for (int i = 0; i < 4000; ++i) {
        plant.drive_duty(i / 500 % 2 == 0 ? 1.0 : -1.0);
        plant.run(supply_v);
        ASSERT_LE(std::abs(plant.position_rad()), 0.5);
    }
    EXPECT_EQ(plant.position_rad(), -0.5);
    EXPECT_EQ(plant.velocity_rad_s(), 0.0);
}

TEST(Plant, AJammedGearStandsStillUnderFullCurrent)
{
    Plant plant(geared());
    plant.drive_duty(1.0);
    run(plant, 0.5);
    const double where = plant.position_rad();
    plant.jam(true);
    run(plant, 0.5);
    EXPECT_EQ(plant.position_rad(), where);
    expect_near(plant.current_a(), 4.0);
    plant.jam(false);
    run(plant, 0.1);
    EXPECT_GT(plant.position_rad(), where);
}

TEST(Plant, ACurrentIsKeptAsFarAsTheVoltageAllows)
{
    const PlantParameters p = geared();
    Plant plant(p);
    plant.drive_current(2.0);
    run(plant, 0.01);
    EXPECT_DOUBLE_EQ(plant.current_a(), 2.0);
    expect_near(plant.velocity_rad_s(), 2.0 * p.torque_per_ampere_nm() / p.inertia_kg_m2() * 0.01);
    run(plant, 2.0); // until the back-EMF leaves nothing
    expect_near(plant.velocity_rad_s(), supply_v / p.voltage_constant_v_s_per_rad());
    EXPECT_LT(plant.current_a(), 0.05);
}

TEST(Plant, WindingAndCaseWarmUpWithTheirTimeConstants)
{
    PlantParameters p = geared();
    p.stop_max_rad = 0.0;
    p.winding_heat_capacity_j_per_k = 15.0;
    p.winding_to_case_k_per_w = 0.5;
    p.case_heat_capacity_j_per_k = 1e9; // as good as water: the case stays cool, the winding has one time constant
    p.case_to_ambient_k_per_w = 1.0;
    Plant plant(p);
    plant.drive_duty(0.5);
    const double heat_w = 2.0 * 2.0 * p.winding_ohm;
    run(plant, 7.5);
    expect_near(plant.winding_c() - 25.0, heat_w * 0.5 * (1.0 - std::exp(-1.0)));
    run(plant, 100.0);
    expect_near(plant.winding_c() - 25.0, heat_w * 0.5);

    p.case_heat_capacity_j_per_k = 100.0;
    p.winding_heat_capacity_j_per_k = 0.5; // as good as none: the case has one time constant of 100 s
    Plant small(p);
    small.drive_duty(0.5);
    run(small, 100.0);
    expect_near(small.case_c() - 25.0, heat_w * 1.0 * (1.0 - std::exp(-1.0)));
    small.open();
    run(small, 100.0);
    expect_near(small.case_c() - 25.0, heat_w * 1.0 * (1.0 - std::exp(-1.0)) * std::exp(-1.0));
}

TEST(Plant, AsksForNoMemoryAndGivesTheSameNumbersEveryTime)
{
    PlantParameters p = geared();
    p.gravity_torque_nm = 3.0;
    p.coulomb_friction_nm = 0.3;
    Plant first(p);
    Plant second(p);
    const auto before = support::allocations();
    for (int i = 0; i < 1000; ++i)
        for (Plant* plant : {&first, &second}) {
            plant->drive_duty(i % 7 / 7.0);
            plant->run(supply_v);
        }
    EXPECT_EQ(support::allocations(), before);
    EXPECT_EQ(first.position_rad(), second.position_rad());
    EXPECT_EQ(first.winding_c(), second.winding_c());
}

TEST(Supply, SagsByItsResistanceForAllWhoShareIt)
{
    Supply supply(24.0, 0.5);
    for (int i = 0; i < 1000; ++i) {
        supply.begin();
        supply.take(4.0);
        supply.take(2.0);
        supply.run();
    }
    EXPECT_NEAR(supply.voltage_v(), 21.0, 1e-9);
}

TEST(Supply, IsForcedDownAndComesBack)
{
    Supply supply(24.0, 0.5);
    const auto settle = [&] {
        for (int i = 0; i < 100; ++i) {
            supply.begin();
            supply.run();
        }
    };
    supply.set(6.0);
    settle();
    EXPECT_NEAR(supply.voltage_v(), 6.0, 1e-9);
    supply.restore();
    settle();
    EXPECT_NEAR(supply.voltage_v(), 24.0, 1e-9);
}

TEST(Supply, NeverFallsBelowNothing)
{
    Supply supply(24.0, 10.0);
    for (int i = 0; i < 100; ++i) {
        supply.begin();
        supply.take(100.0);
        supply.run();
        ASSERT_GE(supply.voltage_v(), 0.0);
    }
}

} // namespace
} // namespace sinew::sim
