#include "sinew/family/sam/models.hpp"

#include "sinew/family/sam/messages.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>
#include <set>

namespace sinew::sam {
namespace {

const Model& model(std::string_view name)
{
    const Model* found = find_model(name);
    EXPECT_NE(found, nullptr) << name;
    return *found;
}

/// A raw value of a field of the reply (or of the request) as the codec by name reads it.
double read(const Model& m, std::string_view message, std::string_view field, std::int64_t raw)
{
    const wire::MessageInfo* info = profiles().front().line.find(message);
    for (const auto* side : {&info->reply, &info->request})
        for (const wire::Field& f : side->fields)
            if (f.name == field)
                return wire::reading(*info, f, {}, m.overrides).physical(raw);
    ADD_FAILURE() << message << " has no " << field;
    return 0.0;
}

wire::Range range(const Model& m, std::string_view message, std::string_view field)
{
    const wire::MessageInfo* info = profiles().front().line.find(message);
    for (const wire::Field& f : info->request.fields)
        if (f.name == field)
            return wire::reading(*info, f, {}, m.overrides).range;
    return {};
}

TEST(SamModels, AreTheSixOfTheManualWithTheirNumbers)
{
    // L705-710, L2748-2752
    ASSERT_EQ(models().size(), 6U);
    EXPECT_EQ(model("SAM-5").number, 0x05);
    EXPECT_EQ(model("SAM-20").number, 0x20);
    EXPECT_EQ(model("SAM-28").number, 0x28);
    EXPECT_EQ(model("SAM-160EO200").number, 0x16);
    EXPECT_EQ(model("SAM-180EO200").number, 0x18);
    EXPECT_EQ(model("SAM-210EO200").number, 0x21);
    for (const Model& m : models())
        EXPECT_EQ(find_model(m.number), &m) << m.name;
    EXPECT_EQ(find_model(std::uint8_t{0x14}), nullptr) << "SAM-140 has no constants";
}

TEST(SamModels, AreFoundByTheNamesPeopleUse)
{
    EXPECT_EQ(find_model("SAM-160"), find_model("SAM-160EO200"));
    EXPECT_EQ(find_model("SAM-160E0200"), find_model("SAM-160EO200")) << "with a zero, as the table prints it";
    EXPECT_EQ(find_model("sam-210eo200"), find_model("SAM-210"));
    EXPECT_EQ(find_model("SAM-340"), nullptr);
    EXPECT_EQ(find_model(""), nullptr);
}

TEST(SamModels, RatingsAreThoseOfTheSpecificationTable)
{
    // L168-173: kgf·cm, volts, amperes, rpm, volts from … to
    struct Printed {
        std::string_view name;
        double kgf_cm, volt, ampere, rpm, volt_min, volt_max;
    };
    for (const Printed& p : {Printed{"SAM-5", 5, 11, 1.5, 130, 6, 15}, Printed{"SAM-20", 20, 19, 2, 140, 9, 24},
                             Printed{"SAM-28", 28, 19, 2, 90, 9, 24}, Printed{"SAM-160", 160, 24, 5, 63, 14, 24},
                             Printed{"SAM-180", 180, 24, 5, 50, 14, 24}, Printed{"SAM-210", 210, 24, 5, 42, 14, 24}}) {
        const Ratings& r = model(p.name).ratings;
        EXPECT_DOUBLE_EQ(r.max_torque_nm, p.kgf_cm * 0.0980665) << p.name;
        EXPECT_DOUBLE_EQ(r.max_speed_rad_s, p.rpm * std::numbers::pi / 30) << p.name;
        EXPECT_EQ(r.rated_voltage_v, p.volt) << p.name;
        EXPECT_EQ(r.rated_current_a, p.ampere) << p.name;
        EXPECT_EQ(r.voltage_min_v, p.volt_min) << p.name;
        EXPECT_EQ(r.voltage_max_v, p.volt_max) << p.name;
    }
}

TEST(SamModels, QuickPositionsAre1_08DegreesWithTheirCentreAt127)
{
    // L392, L462, L758: 254 positions over 273.24 deg
    for (const Model& m : models()) {
        EXPECT_EQ(m.quick.control, (Range{1, 254}));
        EXPECT_EQ(m.quick.centre, 127);
        EXPECT_NEAR(253 * m.quick.deg_per_unit, 273.24, 1e-9);
        EXPECT_EQ(m.quick.span_deg, 273.24);
        EXPECT_NEAR(read(m, "quick-read-status", "position", 128), 1.08, 1e-12);
        EXPECT_NEAR(read(m, "quick-position-control", "target_position", 127), 0.0, 1e-12);
        EXPECT_EQ(range(m, "quick-position-control", "target_position"), (Range{1, 254}));
    }
}

TEST(SamModels, StandardPositionsHaveThePrintedSteps)
{
    // L571-583, L736-750, L758-765
    struct Printed {
        std::string_view name;
        Range control;
        int centre;
        double step_deg, span_deg;
        int positions;
    };
    for (const Printed& p : {Printed{"SAM-5", {32, 4064}, 2047, 0.083, 334.66, 4033},
                             Printed{"SAM-20", {32, 4064}, 2047, 0.083, 334.66, 4033},
                             Printed{"SAM-28", {32, 4064}, 2047, 0.083, 334.66, 4033},
                             Printed{"SAM-160", {82, 28927}, 14504, 0.01241, 357.99, 28846},
                             Printed{"SAM-180", {89, 31530}, 15809, 0.01138, 357.99, 31442},
                             Printed{"SAM-210", {86, 30224}, 15154, 0.01187, 357.99, 30139}}) {
        const Model& m = model(p.name);
        EXPECT_EQ(m.standard.control, p.control) << p.name;
        EXPECT_EQ(p.control.high - p.control.low + 1, p.positions) << p.name;
        EXPECT_EQ(m.standard.centre, p.centre) << p.name;
        EXPECT_EQ(m.standard.deg_per_unit, p.step_deg) << p.name;
        EXPECT_EQ(m.standard.span_deg, p.span_deg) << p.name;
        EXPECT_NEAR(read(m, "read-current-position", "position", p.centre + 1), p.step_deg, 1e-9) << p.name;
        EXPECT_EQ(range(m, "position-control", "target_position"), p.control) << p.name;
    }
}

TEST(SamModels, PrecisePositionsHaveThePrintedStepsAndOnlyTheEncoderClassHasThem)
{
    // L759-765, L773-799
    struct Printed {
        std::string_view name;
        Range control;
        std::int64_t full_scale;
        int centre;
        double step_deg;
    };
    for (const Printed& p : {Printed{"SAM-160", {566, 202494}, 203059, 101529, 0.001773},
                             Printed{"SAM-180", {704, 252248}, 252951, 126475, 0.001423},
                             Printed{"SAM-210", {843, 302251}, 303093, 151546, 0.001187}}) {
        const Model& m = model(p.name);
        ASSERT_TRUE(m.precise) << p.name;
        EXPECT_EQ(m.precise->control, p.control) << p.name;
        EXPECT_EQ(m.precise->sensor, (Range{0, p.full_scale})) << p.name;
        EXPECT_EQ(m.precise->centre, p.centre) << p.name;
        EXPECT_EQ(m.precise->deg_per_unit, p.step_deg) << p.name;
        EXPECT_NEAR(read(m, "read-precise-position", "position", p.centre - 1), -p.step_deg, 1e-9) << p.name;
        EXPECT_EQ(range(m, "precise-position-control", "target_position"), p.control) << p.name;
    }
    for (const auto* name : {"SAM-5", "SAM-20", "SAM-28"})
        EXPECT_FALSE(model(name).precise) << name;
}

TEST(SamModels, TheStandardCentreIsThePreciseOneDividedByTheFactorOfTheSpeedFormula)
{
    // L529-534: 7, 8, 10 (S54)
    EXPECT_EQ(model("SAM-160").precise->centre / 7, model("SAM-160").standard.centre);
    EXPECT_EQ(model("SAM-180").precise->centre / 8, model("SAM-180").standard.centre);
    EXPECT_EQ(model("SAM-210").precise->centre / 10, model("SAM-210").standard.centre);
}

TEST(SamModels, APositionScaleTurnsRawIntoRadiansAndBack)
{
    const PositionScale& scale = model("SAM-160").standard;
    EXPECT_NEAR(scale.rad(14504 + 1000), 12.41 * std::numbers::pi / 180, 1e-12);
    EXPECT_NEAR(scale.raw(scale.rad(20000)), 20000, 1e-9);
    EXPECT_NEAR(scale.raw(0.0), 14504, 1e-12);
}

TEST(SamModels, CurrentsHaveThePrintedScales)
{
    // L394-396, L450-452 (8 bit) and L563-565, L605-607 (12 bit)
    for (const Model& m : models()) {
        const double ad8 = m.encoder ? 0.016 : 0.01289;
        const double ad12 = m.encoder ? 0.001 : 0.00081;
        EXPECT_EQ(m.current_a_per_ad8, ad8) << m.name;
        EXPECT_EQ(m.current_a_per_ad12, ad12) << m.name;
        EXPECT_DOUBLE_EQ(read(m, "quick-read-status", "load", 104), 104 * ad8) << m.name;
        EXPECT_DOUBLE_EQ(read(m, "quick-set-overload", "overload", 104), 104 * ad8) << m.name;
        EXPECT_DOUBLE_EQ(read(m, "read-current-load", "current_load", 1000), 1000 * ad12) << m.name;
        EXPECT_DOUBLE_EQ(read(m, "set-overload", "overload", 1000), 1000 * ad12) << m.name;
    }
}

TEST(SamModels, SupplyVoltageIsScaledAndHasAnOffset)
{
    // L678-680
    EXPECT_DOUBLE_EQ(read(model("SAM-5"), "read-input-voltage", "input_voltage", 1000), 4.83 + 0.65);
    EXPECT_DOUBLE_EQ(read(model("SAM-20"), "read-input-voltage", "input_voltage", 1000), 8.86 + 0.65);
    EXPECT_DOUBLE_EQ(read(model("SAM-28"), "read-input-voltage", "input_voltage", 0), 0.65);
    EXPECT_DOUBLE_EQ(read(model("SAM-160"), "read-input-voltage", "input_voltage", 2000), 17.72 + 0.65);
}

TEST(SamModels, SpeedAndAccelerationHaveThePrintedFactors)
{
    // L527-557
    struct Printed {
        std::string_view name;
        int window_ms;
        double deg_s, deg_s2;
    };
    for (const Printed& p : {Printed{"SAM-5", 10, 8.3, 8300}, Printed{"SAM-20", 10, 8.3, 8300},
                             Printed{"SAM-28", 10, 8.3, 8300}, Printed{"SAM-160", 8, 0.2216, 221.6},
                             Printed{"SAM-180", 8, 0.1778, 177.8}, Printed{"SAM-210", 8, 0.1483, 148.3}}) {
        const Model& m = model(p.name);
        EXPECT_EQ(m.speed_window, std::chrono::milliseconds{p.window_ms}) << p.name;
        EXPECT_DOUBLE_EQ(read(m, "read-current-speed", "current_speed", -100), -100 * p.deg_s) << p.name;
        EXPECT_DOUBLE_EQ(read(m, "read-current-accel", "current_accel", 100), 100 * p.deg_s2) << p.name;
    }
}

TEST(SamModels, SpeedFactorsFollowFromStepFactorAndWindow)
{
    // L529-536: 0.01241·Δ/7/0.008 and so on, rounded to the four digits that are printed
    const auto follows = [](std::string_view name, double factor) {
        const Model& m = model(name);
        return m.standard.deg_per_unit / factor / seconds(m.speed_window);
    };
    EXPECT_NEAR(follows("SAM-160", 7), model("SAM-160").speed_deg_s_per_unit, 5e-5);
    EXPECT_NEAR(follows("SAM-180", 8), model("SAM-180").speed_deg_s_per_unit, 5e-5);
    EXPECT_NEAR(follows("SAM-210", 10), model("SAM-210").speed_deg_s_per_unit, 1e-4); // 0.148375, printed 0.1483 (S57)
    EXPECT_NEAR(follows("SAM-5", 1), model("SAM-5").speed_deg_s_per_unit, 1e-12);
}

TEST(SamModels, BoundariesOfNinetyDegreesAreThePrintedOnes)
{
    // L462-466: quick 44 … 210; L617-621: encoder class 63 … 191; L627-631: the others 59 … 195
    EXPECT_NEAR(read(model("SAM-5"), "quick-set-boundary", "upper_boundary", 210), 90, 1.08);
    EXPECT_NEAR(read(model("SAM-5"), "quick-set-boundary", "lower_boundary", 44), -90, 1.08);
    EXPECT_DOUBLE_EQ(read(model("SAM-160"), "set-boundary", "upper_boundary", 191), 64 * 1.41);
    EXPECT_DOUBLE_EQ(read(model("SAM-160"), "set-boundary", "lower_boundary", 63), -64 * 1.41);
    EXPECT_DOUBLE_EQ(read(model("SAM-28"), "read-boundary", "upper_boundary", 195), 68 * 1.32);
    EXPECT_DOUBLE_EQ(read(model("SAM-28"), "read-boundary", "lower_boundary", 59), -68 * 1.32);
}

TEST(SamModels, TheExternalInputReaches5_5Volts)
{
    // L484-486
    EXPECT_NEAR(4095 * external_v_per_ad, 5.5, 0.001);
    EXPECT_DOUBLE_EQ(read(model("SAM-160"), "read-external-ad", "external_ad", 1000), 1.343);
}

TEST(SamModels, EveryScaleThatARowLeavesToTheModelIsGivenByEveryModel)
{
    for (const Model& m : models())
        for (const wire::MessageInfo* message : profiles().front().line.messages) {
            if (!offers(m, *message))
                continue;
            for (const auto* side : {&message->request, &message->reply})
                for (const wire::Field& f : side->fields)
                    if (f.kind == wire::Kind::value && !f.unit.empty()) {
                        EXPECT_NE(wire::reading(*message, f, {}, m.overrides).scale, 0.0)
                            << m.name << " " << message->name() << " " << f.name;
                    }
        }
}

TEST(SamModels, EveryOverrideNamesAMessageAndAFieldThatExist)
{
    for (const Model& m : models())
        for (const wire::Override& o : m.overrides) {
            const wire::MessageInfo* message = profiles().front().line.find(o.message);
            ASSERT_NE(message, nullptr) << o.message;
            const auto has = [&](const wire::Side& side) {
                return std::ranges::any_of(side.fields, [&](const wire::Field& f) { return f.name == o.field; });
            };
            EXPECT_TRUE(has(message->request) || has(message->reply)) << o.message << " " << o.field;
        }
}

TEST(SamModels, OnlyTheEncoderClassHasTheRestrictedMessages)
{
    const wire::Profile& line = profiles().front().line;
    for (const auto* name : {"read-precise-position", "precise-position-control", "offset-control",
                             "write-external-port", "quick-read-external-ad"}) {
        EXPECT_TRUE(offers(model("SAM-210"), *line.find(name))) << name;
        EXPECT_FALSE(offers(model("SAM-28"), *line.find(name))) << name;
    }
    EXPECT_TRUE(offers(model("SAM-5"), *line.find("position-control")));
}

TEST(SamProfile, OptionsBecomeTheSwitchesOfTheRows)
{
    Profile profile = profiles().front();
    EXPECT_EQ(profile.options().bits, 0U);
    profile.quick_boundary_order = BoundaryOrder::lower_then_upper;
    EXPECT_EQ(profile.options().bits, quick_boundary_lower_first);
    profile.quick_port_bits = PortBits::do_low;
    EXPECT_EQ(profile.options().bits, quick_boundary_lower_first | quick_port_outputs_low);
}

} // namespace
} // namespace sinew::sam
