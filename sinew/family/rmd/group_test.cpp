#include "sinew/family/rmd/group.hpp"

#include "sinew/family/rmd/lines.hpp"
#include "tests/support/allocations.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace sinew::rmd {
namespace {

using actuator::Mode;

Driver motor(int id, std::string_view model = "MG", std::string_view line = "rmd-2.35")
{
    const auto profile = std::ranges::find(profiles(), line, [](const Profile& p) { return p.line.name; });
    Profile known = *profile;
    known.torque_constant_nm_per_a = 0.5;
    return Driver(make_spec(*find_model(model), known, id));
}

actuator::Command current(double a)
{
    return {.mode = Mode::current, .current_a = a};
}

Errc refused(std::span<const GroupMember> members)
{
    const auto plan = plan_group(members);
    EXPECT_FALSE(plan.has_value());
    return plan ? Errc::stopped : plan.error().code;
}

TEST(RmdGroup, PutsTheCurrentsOfAllItsMotorsIntoOneFrame) // L1127: 2000 is 32 A
{
    Driver one = motor(1), three = motor(3), four = motor(4);
    const GroupMember members[] = {{&four, {.mode = Mode::torque, .torque_nm = 0.4}}, // 0.8 A
                                   {&one, current(32.0)},
                                   {&three, current(-1.6)}};
    const auto plan = plan_group(members);
    ASSERT_TRUE(plan.has_value()) << to_sentence(plan.error());
    ASSERT_EQ(plan->all().size(), 1U);
    EXPECT_EQ(plan->all()[0].frame.can_id, 0x280U);
    EXPECT_EQ(plan->all()[0].frame,
              *wire::encode_request(-1, MultiMotorTorque{.iq_1 = 2000, .iq_2 = 0, .iq_3 = -100, .iq_4 = 50}));
}

TEST(RmdGroup, EachDriverTakesItsOwnAnswer) // R25
{
    Driver one = motor(1), two = motor(2);
    const GroupMember members[] = {{&one, current(1.0)}, {&two, current(2.0)}};
    const auto plan = plan_group(members);
    actuator::State first, second;
    for (const int id : {1, 2}) {
        auto reply = *wire::encode_reply<TorqueClosedLoop>(
            id, {.temperature = static_cast<std::int8_t>(20 + id), .iq = 0, .speed = 0, .encoder = 0});
        ASSERT_TRUE(one.absorb(plan->all()[0], reply, TimePoint{}, first).has_value());
        ASSERT_TRUE(two.absorb(plan->all()[0], reply, TimePoint{}, second).has_value());
    }
    EXPECT_EQ(first.temperature_c, 21.0);
    EXPECT_EQ(second.temperature_c, 22.0);
}

TEST(RmdGroup, RunsTheMotorsThatAreOffFirst)
{
    Driver one = motor(1), two = motor(2);
    ASSERT_TRUE(two.plan({.mode = Mode::release}, {}).has_value());
    const GroupMember members[] = {{&one, current(1.0)}, {&two, current(2.0)}};
    const auto plan = plan_group(members);
    ASSERT_EQ(plan->all().size(), 2U);
    EXPECT_EQ(plan->all()[0].message->name(), "motor-running");
    EXPECT_EQ(plan->all()[0].id, 2);
}

TEST(RmdGroup, RefusesWhatTheFrameCannotSayAndPlansNothing)
{
    Driver one = motor(1), five = motor(5), small = motor(2, "MF"), other = motor(2, "MG", "myactuator-3");
    EXPECT_EQ(refused({}), Errc::bad_argument);
    EXPECT_EQ(refused({{GroupMember{&five, current(1.0)}}}), Errc::unsupported);
    EXPECT_EQ(refused({{GroupMember{&one, current(32.1)}}}), Errc::out_of_range);
    EXPECT_EQ(refused({{GroupMember{&one, {.mode = Mode::velocity, .velocity_rad_s = 1.0}}}}), Errc::bad_argument);
    EXPECT_EQ(refused({{GroupMember{&one, current(1.0)}, GroupMember{&one, current(1.0)}}}), Errc::bad_argument);
    EXPECT_EQ(refused({{GroupMember{&small, current(1.0)}}}), Errc::unsupported) << "its scale is not printed (R11)";
    EXPECT_EQ(refused({{GroupMember{&other, current(1.0)}}}), Errc::unsupported) << "its line has no such message";
}

TEST(RmdGroup, AsksTheHeapForNothing)
{
    Driver one = motor(1), two = motor(2);
    const auto before = support::allocations();
    for (int i = 0; i < 1000; ++i) {
        const GroupMember members[] = {{&one, current(i * 0.01)}, {&two, current(i * -0.01)}};
        if (!plan_group(members))
            FAIL() << i;
    }
    EXPECT_EQ(support::allocations(), before);
}

} // namespace
} // namespace sinew::rmd
