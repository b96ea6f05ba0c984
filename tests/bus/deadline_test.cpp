#include "sinew/family/rmd/group.hpp"
#include "sinew/family/rmd/lines.hpp"
#include "tests/bus/rig.hpp"
#include "tests/support/random.hpp"

#include <gtest/gtest.h>

/// In virtual time every wait ends at the nanosecond that can be computed before: bits both ways, response time,
/// margin.
namespace sinew::tests {
namespace {

using namespace std::chrono_literals;

constexpr Duration response = 137us;
constexpr int id = 3;

std::optional<sim::Answer> silence(const wire::Frame&, TimePoint)
{
    return {};
}

/// What a try that nobody answers takes.
Duration one_try(const bus::Bus& bus, const wire::Request& request, Duration margin)
{
    return predict(bus.conversation().line(), request).total() + margin;
}

template <class M>
wire::Request request(const M& message)
{
    return *wire::make_request(id, message, {}, response);
}

/// How long a call takes that must fail.
template <class M>
Duration wasted(bus::Bus& bus, const M& message)
{
    bus.set_device(id, {.response_time = response});
    const TimePoint start = bus.clock().now();
    const auto answer = bus.call(id, message);
    EXPECT_FALSE(answer.has_value());
    EXPECT_EQ(answer.error().code, Errc::timeout);
    return bus.clock().now() - start;
}

/// The margin once answers have been measured is not the first one.
template <class M>
void warm_up(bus::Bus& bus, const M& message)
{
    bus.set_device(id, {.response_time = response});
    for (int i = 0; i < 20; ++i)
        ASSERT_TRUE(bus.call(id, message).has_value());
}

TEST(Deadline, OfANuriReadIsThatOfBothTries)
{
    WireClock clock;
    SerialRig rig(clock, nuri::protocol(), 1'000'000);
    rig.add(id, silence);
    const auto asked = request(nuri::RequestPositionFeedback{});
    const Duration margin = bus::Settings{}.margin_at_first;
    EXPECT_EQ(wasted(*rig.bus, nuri::RequestPositionFeedback{}), 2 * one_try(*rig.bus, asked, margin));
}

TEST(Deadline, FollowsTheMarginThatWasMeasured)
{
    WireClock clock;
    SerialRig rig(clock, nuri::protocol(), 1'000'000, {.margin_least = 1ms + 1ns});
    bool is_silent = false;
    rig.add(id, [&](const wire::Frame& heard, TimePoint) -> std::optional<sim::Answer> {
        if (is_silent)
            return {};
        return sim::Answer{*wire::encode_reply<nuri::RequestPositionFeedback>(heard.data[2], {}), response};
    });
    warm_up(*rig.bus, nuri::RequestPositionFeedback{});
    is_silent = true;
    EXPECT_EQ(rig.bus->conversation().margin(), 1ms + 1ns);
    const auto asked = request(nuri::RequestPositionFeedback{});
    EXPECT_EQ(wasted(*rig.bus, nuri::RequestPositionFeedback{}), 2 * one_try(*rig.bus, asked, 1ms + 1ns));
}

TEST(Deadline, OfAnRmdReadIsThatOfBothTries)
{
    WireClock clock;
    CanRig rig(clock, 1'000'000);
    rig.add(id, silence);
    const auto asked = request(rmd::ReadStatus2{});
    const Duration margin = bus::Settings{}.margin_at_first;
    EXPECT_EQ(wasted(*rig.bus, rmd::ReadStatus2{}), 2 * one_try(*rig.bus, asked, margin));
}

TEST(Deadline, OfACommandIsThatOfItsOnlyTry)
{
    WireClock clock;
    CanRig rig(clock, 1'000'000);
    rig.add(id, silence);
    const auto asked = request(rmd::TorqueClosedLoop{});
    EXPECT_EQ(wasted(*rig.bus, rmd::TorqueClosedLoop{}), one_try(*rig.bus, asked, bus::Settings{}.margin_at_first));
}

TEST(Deadline, OfASamReadIsThatOfItsTryTheSilenceAndTheProbe)
{
    WireClock clock;
    SerialRig rig(clock, sam::protocol(), 1'000'000);
    rig.add(id, silence);
    const auto asked = request(sam::QuickReadStatus{});
    auto probe = *sam::protocol().probe(id);
    probe.response_time = response;
    const bus::Settings settings;
    EXPECT_EQ(wasted(*rig.bus, sam::QuickReadStatus{}), one_try(*rig.bus, asked, settings.margin_at_first) +
                                                            settings.late_max +
                                                            one_try(*rig.bus, probe, settings.margin_at_first));
}

TEST(Deadline, OfManyOnCanIsThatOfTheWireThatCarriesThemAll)
{
    WireClock clock;
    CanRig rig(clock, 1'000'000, {.read_retries = 0});
    std::vector<wire::Request> requests;
    for (int motor = 1; motor <= 12; ++motor) {
        rig.add(motor, silence);
        requests.push_back(*wire::make_request(motor, rmd::ReadStatus2{}, {}, response));
    }
    std::vector<bus::Result> results(requests.size());
    const TimePoint start = clock.now();
    ASSERT_TRUE(rig.bus->exchange(requests, results).has_value());
    const auto one = predict(rig.bus->conversation().line(), requests[0]);
    const Duration margin = bus::Settings{}.margin_at_first;
    EXPECT_EQ(clock.now() - start, 12 * one.wire() + one.response + margin);
}

template <class Answer>
std::optional<Errc> error_of(const Answer& answer)
{
    return answer ? std::nullopt : std::optional(answer.error().code);
}

/// An answer at any time, late, torn off, twice, or none: no call returns later than one that nobody answers. Of every
/// family; one that is answered badly may come back sooner.
TEST(Deadline, IsNeverPassedWhateverComesWhenever)
{
    test::Random random("deadline");
    SCOPED_TRACE(testing::Message() << "SINEW_SEED=" << test::seed());
    int failed = 0;
    for (int round = 0; round < 2000; ++round) {
        WireClock clock;
        const bool is_can = random.below(2) == 0;
        std::optional<SerialRig> serial;
        std::optional<CanRig> can;
        const auto answer = [&](const wire::Frame& reply) -> std::optional<sim::Answer> {
            if (random.below(4) == 0)
                return {};
            sim::Answer out{reply, Duration{static_cast<std::int64_t>(random.below(80'000'000))}};
            if (!is_can && random.below(3) == 0)
                out.frame.size = static_cast<std::uint8_t>(1 + random.below(reply.size));
            return out;
        };
        if (is_can) {
            can.emplace(clock, 1'000'000);
            can->add(id, [&](const wire::Frame&, TimePoint) {
                return answer(*wire::encode_reply<rmd::ReadStatus2>(id, {}));
            });
        } else {
            serial.emplace(clock, nuri::protocol(), 1'000'000);
            serial->add(id, [&](const wire::Frame&, TimePoint) {
                return answer(*wire::encode_reply<nuri::RequestPositionFeedback>(id, {}));
            });
        }
        bus::Bus& bus = is_can ? *can->bus : *serial->bus;
        bus.set_device(id, {.response_time = response});
        const auto asked = is_can ? request(rmd::ReadStatus2{}) : request(nuri::RequestPositionFeedback{});
        for (int call = 0; call < 4; ++call) {
            const Duration limit = 2 * one_try(bus, asked, bus.conversation().margin());
            const TimePoint start = clock.now();
            const auto result = is_can ? error_of(bus.call(id, rmd::ReadStatus2{}))
                                       : error_of(bus.call(id, nuri::RequestPositionFeedback{}));
            const Duration took = clock.now() - start;
            ASSERT_LE(took, limit) << "round " << round << " call " << call;
            if (result == Errc::timeout) {
                ASSERT_EQ(took, limit) << "round " << round << " call " << call;
                ++failed;
            }
        }
    }
    EXPECT_GT(failed, 100);
}

TEST(Deadline, OfBareAnswersIsNeverPassedWhateverComesWhenever)
{
    test::Random random("deadline");
    SCOPED_TRACE(testing::Message() << "SINEW_SEED=" << test::seed());
    int failed = 0;
    for (int round = 0; round < 1000; ++round) {
        WireClock clock;
        SerialRig rig(clock, sam::protocol(), 1'000'000);
        rig.add(id, [&](const wire::Frame&, TimePoint) -> std::optional<sim::Answer> {
            if (random.below(4) == 0)
                return {};
            sim::Answer out{*wire::encode_reply<sam::QuickReadStatus>(id, {.load = 1, .position = id}),
                            Duration{static_cast<std::int64_t>(random.below(80'000'000))}};
            out.frame.size = static_cast<std::uint8_t>(1 + random.below(3));
            return out;
        });
        rig.bus->set_device(id, {.response_time = response});
        const auto asked = request(sam::QuickReadStatus{});
        for (int call = 0; call < 3; ++call) {
            const Duration limit = rig.bus->conversation().longest({&asked, 1});
            const TimePoint start = clock.now();
            failed += rig.bus->call(id, sam::QuickReadStatus{}).has_value() ? 0 : 1;
            ASSERT_LE(clock.now() - start, limit) << "round " << round << " call " << call;
        }
    }
    EXPECT_GT(failed, 100);
}

/// No looser than what can really follow one another: `longest` is what a caller plans with.
TEST(Deadline, LongestCountsEveryTryOnceAndBareReadsTwiceWhereTheyMustAgree)
{
    WireClock clock;
    const bus::Settings settings;
    SerialRig framed(clock, nuri::protocol(), 1'000'000);
    const auto framed_read = request(nuri::RequestPositionFeedback{});
    EXPECT_EQ(framed.bus->conversation().longest({&framed_read, 1}),
              2 * one_try(*framed.bus, framed_read, settings.margin_most));

    const auto read = request(sam::QuickReadStatus{});
    auto probe = *sam::protocol().probe(id);
    for (const bool double_read : {false, true}) {
        SerialRig bare(clock, sam::protocol(), 1'000'000, {.double_read = double_read});
        const Duration recovery = 10 * settings.late_max + predict(bare.bus->conversation().line(), probe).wire() +
                                  response + settings.margin_most;
        EXPECT_EQ(bare.bus->conversation().longest({&read, 1}),
                  (double_read ? 4 : 2) * (one_try(*bare.bus, read, settings.margin_most) + recovery));
    }
}

rmd::Driver motor(int number)
{
    rmd::Profile known = *std::ranges::find(rmd::profiles(), "rmd-2.35", [](const auto& p) { return p.line.name; });
    return rmd::Driver(make_spec(*rmd::find_model("MG"), known, number));
}

Station::Answer turns(int number)
{
    return [=](const wire::Frame&, TimePoint) -> std::optional<sim::Answer> {
        return sim::Answer{*wire::encode_reply<rmd::TorqueClosedLoop>(number, {.temperature = 30}), response};
    };
}

/// The frame for a torque group ends when all of its motors have answered, and waits for those that are missing only.
TEST(Group, EndsWithTheAnswerOfItsLastMotor)
{
    for (const int there : {1, 2, 3, 4}) {
        WireClock clock;
        CanRig rig(clock, 1'000'000);
        std::vector<rmd::Driver> drivers;
        for (int number = 1; number <= there; ++number) {
            rig.add(number, turns(number));
            drivers.push_back(motor(number));
        }
        std::vector<rmd::GroupMember> members;
        for (auto& driver : drivers)
            members.push_back({&driver, {.mode = actuator::Mode::current, .current_a = 1.0}});
        const auto plan = plan_group(members);
        ASSERT_TRUE(plan.has_value()) << to_sentence(plan.error());
        bus::Result result;
        const TimePoint start = clock.now();
        ASSERT_TRUE(rig.bus->exchange(plan->all(), {&result, 1}).has_value());
        EXPECT_TRUE(result.good);
        EXPECT_EQ(result.reply_count, there);
        EXPECT_LE(clock.now() - start, predict_cycle(rig.bus->conversation().line(), plan->all()) + response);
    }
}

TEST(Group, OfWhichOneIsMissingIsGivenUpAtItsDeadline)
{
    WireClock clock;
    CanRig rig(clock, 1'000'000);
    rig.add(1, turns(1));
    rmd::Driver one = motor(1), two = motor(2);
    const rmd::GroupMember members[] = {{&one, {.mode = actuator::Mode::current, .current_a = 1.0}},
                                        {&two, {.mode = actuator::Mode::current, .current_a = 1.0}}};
    const auto plan = plan_group(members);
    ASSERT_TRUE(plan.has_value()) << to_sentence(plan.error());
    bus::Result result;
    const TimePoint start = clock.now();
    ASSERT_TRUE(rig.bus->exchange(plan->all(), {&result, 1}).has_value());
    EXPECT_EQ(result.reply_count, 1);
    EXPECT_EQ(clock.now() - start, one_try(*rig.bus, plan->all()[0], bus::Settings{}.margin_at_first));
}

TEST(Group, TakesOneAnswerOfEachMotorAndASecondOneIsAStray)
{
    rmd::Driver one = motor(1), two = motor(2);
    const rmd::GroupMember members[] = {{&one, {.mode = actuator::Mode::current, .current_a = 1.0}},
                                        {&two, {.mode = actuator::Mode::current, .current_a = 1.0}}};
    const auto plan = plan_group(members);
    ASSERT_TRUE(plan.has_value()) << to_sentence(plan.error());
    bus::Conversation conversation(rmd::protocol(), {.can = true, .bit_rate = 1'000'000}, {});
    bus::Result result;
    TimePoint now{1s};
    const auto answer = [&](int number) {
        conversation.received(*wire::encode_reply<rmd::TorqueClosedLoop>(number, {.temperature = 30}), now += 1ms);
    };
    for (const unsigned round : {1U, 2U}) {
        conversation.begin(plan->all(), {&result, 1});
        ASSERT_EQ(conversation.next(now).transmit.size(), 1U);
        conversation.transmitted(1, now);
        answer(1);
        answer(1);
        EXPECT_EQ(result.reply_count, 1);
        EXPECT_EQ(conversation.counters().strays, round);
        EXPECT_FALSE(conversation.next(now).done);
        answer(2);
        EXPECT_EQ(result.reply_count, 2);
        EXPECT_TRUE(conversation.next(now).done);
    }
}

TEST(Group, ThatNobodyAnswersIsATimeOut)
{
    WireClock clock;
    CanRig rig(clock, 1'000'000);
    rig.add(id, silence);
    rmd::Driver one = motor(1), two = motor(2);
    const rmd::GroupMember members[] = {{&one, {.mode = actuator::Mode::current, .current_a = 1.0}},
                                        {&two, {.mode = actuator::Mode::current, .current_a = 1.0}}};
    const auto plan = plan_group(members);
    ASSERT_TRUE(plan.has_value()) << to_sentence(plan.error());
    bus::Result result;
    ASSERT_TRUE(rig.bus->exchange(plan->all(), {&result, 1}).has_value());
    EXPECT_FALSE(result.good);
    EXPECT_EQ(result.error.code, Errc::timeout);
    EXPECT_EQ(rig.bus->conversation().counters().timeouts, 1U);
}

} // namespace
} // namespace sinew::tests
