#pragma once
#include "sinew/bus/agree.hpp"
#include "sinew/family/nuri/lines.hpp"
#include "tests/bus/traced_wire.hpp"
#include "tests/support/random.hpp"

#include <cmath>
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <utility>

/// A bus of each family on a wire on which things go wrong, and what became of each result. SINEW_EXCHANGES says how
/// many are asked, SINEW_SEED makes a run again.
namespace sinew::tests {

using namespace std::chrono_literals;

inline std::uint64_t exchanges()
{
    return test::setting("SINEW_EXCHANGES", 30'000);
}

/// What became of the results of a run.
struct Tally {
    std::uint64_t asked = 0;
    std::uint64_t right = 0;
    std::uint64_t none = 0;       ///< an error
    std::uint64_t marked = 0;     ///< of an earlier request like it, and said so
    std::uint64_t unmarked = 0;   ///< the same and not said: never
    std::uint64_t foreign = 0;    ///< of another device or message: never
    std::uint64_t damaged = 0;    ///< the own answer with damaged, lost or added bytes that nothing gives away
    std::uint64_t far_off = 0;    ///< of these, those that `double_read` would not take for the truth
    std::uint64_t by_mistake = 0; ///< the request was damaged into another that is in order
    std::uint64_t invented = 0;   ///< nothing but noise
    std::uint64_t too_late = 0;   ///< returned after its deadline: never
    std::uint64_t quarantines = 0;
    std::uint64_t losses = 0; ///< of the link
    Duration oldest{};        ///< of the unmarked, how long before the request
    Duration waited{};        ///< for answers, altogether
    Duration took{};          ///< the whole run

    void print(std::string_view name) const
    {
        fmt::print(
            "{:<28} {:>9} asked {:>9} right {:>7} errors {:>6} marked {:>5} damaged {:>4} by mistake {:>3} invented | "
            "{} foreign "
            "{} unmarked {} too late\n",
            name, asked, right, none, marked, damaged, by_mistake, invented, foreign, unmarked, too_late);
    }
    void note_older(const bus::Result& result, TimePoint heard_at)
    {
        ++(result.possibly_older ? marked : unmarked);
        if (!result.possibly_older)
            oldest = std::max(oldest, result.sent_at - heard_at);
    }

    /// How much of the time somebody waits for an answer.
    double waiting() const { return std::chrono::duration<double>(waited) / std::chrono::duration<double>(took); }
    double share(std::uint64_t of) const { return static_cast<double>(of) / static_cast<double>(asked); }

    /// Of so many that happen by chance with a probability of `computed` at most.
    void expect_at_most(std::uint64_t wrong, double computed) const
    {
        const double expected = computed * static_cast<double>(asked);
        EXPECT_LE(static_cast<double>(wrong), expected + 5 * std::sqrt(expected) + 5);
    }
    void expect_near(std::uint64_t wrong, double computed) const
    {
        expect_at_most(wrong, computed);
        const double expected = computed * static_cast<double>(asked);
        EXPECT_GE(static_cast<double>(wrong), expected - 5 * std::sqrt(expected));
    }

    void expect_none_wrong() const
    {
        EXPECT_EQ(foreign, 0U);
        EXPECT_EQ(unmarked, 0U);
        EXPECT_EQ(too_late, 0U);
    }
};

/// A batch of requests, for any family.
struct Ask {
    std::vector<wire::Request> requests;
    std::vector<bus::Result> results;
};

/// Whether the waits kept to what was computed. A result that never went out in its last try has no deadline.
inline void check_waits(const bus::Bus& bus, const Ask& ask, TimePoint began, Tally& tally)
{
    tally.too_late += bus.clock().now() - began > bus.conversation().longest(ask.requests);
    for (const auto& result : ask.results)
        tally.too_late += (result.good || (!bus.protocol().bare_replies() && result.error.code == Errc::timeout)) &&
                          result.at > result.deadline;
    for (std::size_t i = 0; i < ask.results.size(); ++i)
        if (const auto& result = ask.results[i]; ask.requests[i].answered && result.tries > 0)
            tally.waited += (result.good ? result.at : result.deadline) - result.sent_at +
                            (result.tries - 1) * (result.deadline - result.sent_at);
    tally.took = bus.clock().now().time_since_epoch() - std::chrono::seconds(1);
}

// ---- serial families ----

/// Judges a bare reply by where its bytes came from.
inline void judge_bare(const TracedWire& wire, const wire::Request& asked, const bus::Result& result, Tally& tally)
{
    const std::size_t size = result.replies[0].size;
    const auto end = std::ranges::upper_bound(wire.read, result.at, {}, &Coming::at);
    if (static_cast<std::size_t>(end - wire.read.begin()) < size) {
        ++tally.foreign;
        return;
    }
    const auto bytes = std::span(&*end - size, size);
    bool whole = true;
    std::uint32_t source = 0;
    bool mixed = false;
    for (std::size_t i = 0; i < size; ++i) {
        if (bytes[i].byte != result.replies[0].data[i])
            mixed = true; // not what was read last: nothing explains it
        if (bytes[i].given != 0) {
            mixed = mixed || (source != 0 && source != bytes[i].given);
            source = bytes[i].given;
        }
        whole = whole && bytes[i].given != 0 && bytes[i].index == i && !bytes[i].is_damaged;
    }
    const Given& given = wire.given[source];
    if (source != 0 && given.by_mistake)
        ++tally.by_mistake;
    else if (mixed || (source != 0 && (given.id != asked.id || given.message != asked.message)))
        ++tally.foreign;
    else if (source != 0 && given.heard_at < result.sent_at)
        tally.note_older(result, given.heard_at);
    else if (whole)
        ++tally.right;
    else {
        ++(source == 0 ? tally.invented : tally.damaged);
        const auto truth = source != 0 ? given.frame : wire::Frame{};
        tally.far_off += !bus::agree(asked.message->reply, truth, result.replies[0]);
    }
}

/// Judges a framed reply by the number in it; `number_of` reads it.
template <class NumberOf>
void judge_framed(const TracedWire& wire, const wire::Request& asked, const bus::Result& result, NumberOf&& number_of,
                  Tally& tally)
{
    const std::uint32_t number = number_of(*asked.message, result.replies[0]);
    if (number == 0 || number >= wire.given.size() || wire.given[number].frame != result.replies[0]) {
        ++tally.damaged; // no device ever sent this
        return;
    }
    const Given& given = wire.given[number];
    if (given.by_mistake)
        ++tally.by_mistake;
    else if (given.id != asked.id || given.message->reply.opcode != asked.message->reply.opcode)
        ++tally.foreign;
    else if (given.heard_at < result.sent_at)
        tally.note_older(result, given.heard_at);
    else
        ++tally.right;
}

template <class Judge>
Tally run_serial(WireClock& clock, TracedWire& wire, std::span<const wire::Request> choice, std::uint64_t count,
                 Judge&& judge)
{
    Tally tally;
    sim::Dice dice;
    dice.seed(test::seed());
    wire.seed(test::seed() + 1);
    Ask ask;
    while (tally.asked < count) {
        ask.requests.clear();
        for (unsigned i = 1 + dice.pick(4); i > 0; --i)
            ask.requests.push_back(choice[dice.pick(static_cast<unsigned>(choice.size()))]);
        ask.results.resize(ask.requests.size());
        wire.read.clear();
        const TimePoint began = clock.now();
        (void)wire.bus->exchange(ask.requests, ask.results);
        check_waits(*wire.bus, ask, began, tally);
        for (std::size_t i = 0; i < ask.results.size(); ++i) {
            ++tally.asked;
            if (!ask.results[i].good)
                ++tally.none;
            else if (ask.requests[i].answered)
                judge(wire, ask.requests[i], ask.results[i], tally);
            else
                ++tally.right;
        }
        if (dice.falls(0.3)) // now and then the line rests
            clock.wait({}, clock.now() + Duration(dice.pick(100'000)) * 20);
    }
    tally.quarantines = wire.bus->conversation().counters().quarantines;
    tally.losses = wire.bus->losses();
    return tally;
}

inline constexpr bus::Settings settings{.margin_at_first = 5ms};
inline constexpr TracedFaults all_faults{
    .bytes = {.flip_bit = 1e-3, .drop_byte = 1e-3, .add_byte = 1e-3, .delay_reply = 5e-3, .reply_delay = 50ms},
    .cut_cable = 2e-4,
    .dead_device = 2e-4,
    .hang_up = 1e-3};

inline constexpr wire::Profile sam_line{.name = "sam", .messages = sam::manual_messages};
inline constexpr wire::Profile nuri_line{.name = "nuri", .messages = nuri::manual_messages};

inline std::optional<wire::Frame> sam_answer(const wire::MessageInfo& message, int id, std::uint32_t number)
{
    const auto byte = static_cast<std::uint8_t>(id);
    const auto low = static_cast<std::uint8_t>(number % 255);
    const auto high = static_cast<std::uint8_t>(number / 255 % 255);
    if (&message == &wire::info_of<sam::QuickReadStatus>)
        return *wire::encode_reply<sam::QuickReadStatus>(id, {.load = high, .position = low});
    if (&message == &wire::info_of<sam::ReadPdGain>)
        return *wire::encode_reply<sam::ReadPdGain>(id, {.p_gain = low, .d_gain = high});
    if (&message == &wire::info_of<sam::SetRuntimePdGain>)
        return *wire::encode_reply<sam::SetRuntimePdGain>(id, {.p_gain = high, .d_gain = low});
    if (&message == &wire::info_of<sam::QuickPassiveMode>)
        return *wire::encode_reply<sam::QuickPassiveMode>(id, {.id = byte});
    return std::nullopt;
}

inline std::vector<wire::Request> sam_choice(Duration response)
{
    std::vector<wire::Request> all;
    for (int id = 0; id < 8; ++id) {
        all.push_back(*wire::make_request(id, sam::QuickReadStatus{}, {}, response));
        all.push_back(*wire::make_request(id, sam::ReadPdGain{}, {}, response));
        all.push_back(*wire::make_request(id, sam::SetRuntimePdGain{.p_gain = 9, .d_gain = 9}, {}, response));
        all.push_back(*wire::make_request(id, sam::QuickPassiveMode{}, {}, response));
    }
    all.push_back(*wire::make_request(31, sam::QuickBrakeMode{}));
    all.back().answered = false;
    return all;
}

inline Tally run_sam(std::uint64_t count, TracedFaults faults, bus::Settings with = settings)
{
    WireClock clock;
    TracedWire wire(clock, sam::protocol(), sam_line, 1'500'000, 50us, with, std::move(faults),
                    [](const wire::MessageInfo& message, int id, std::uint32_t number) {
                        if (&message == &wire::info_of<sam::Ping>)
                            return std::optional(
                                *wire::encode_reply<sam::Ping>(id, {.id = static_cast<std::uint8_t>(id)}));
                        return sam_answer(message, id, number);
                    });
    const auto choice = sam_choice(50us);
    return run_serial(clock, wire, choice, count, judge_bare);
}

inline std::optional<wire::Frame> nuri_answer(const wire::MessageInfo& message, int id, std::uint32_t number)
{
    const auto low = static_cast<std::uint16_t>(number % 65'000);
    const auto high = static_cast<std::uint16_t>(number / 65'000);
    if (&message == &wire::info_of<nuri::RequestPositionFeedback>)
        return *wire::encode_reply<nuri::RequestPositionFeedback>(id, {.position = low, .speed = high});
    if (&message == &wire::info_of<nuri::RequestSpeedFeedback>)
        return *wire::encode_reply<nuri::RequestSpeedFeedback>(id, {.speed = low, .position = high});
    return std::nullopt;
}

inline std::uint32_t nuri_number(const wire::MessageInfo& message, const wire::Frame& frame)
{
    if (&message == &wire::info_of<nuri::RequestPositionFeedback>)
        if (const auto reply = wire::decode_reply<nuri::RequestPositionFeedback>(frame))
            return reply->message.speed * 65'000U + reply->message.position;
    if (const auto reply = wire::decode_reply<nuri::RequestSpeedFeedback>(frame))
        return reply->message.position * 65'000U + reply->message.speed;
    return 0;
}

inline std::vector<wire::Request> nuri_choice()
{
    std::vector<wire::Request> all;
    for (int id = 0; id < 8; ++id) {
        all.push_back(*wire::make_request(id, nuri::RequestPositionFeedback{}, {}, 100us));
        all.push_back(*wire::make_request(id, nuri::RequestSpeedFeedback{}, {}, 100us));
    }
    all.push_back(*wire::make_request(255, nuri::SetControlOnOff{.control = nuri::Control::off}));
    return all;
}

inline Tally run_nuri(std::uint64_t count, TracedFaults faults)
{
    WireClock clock;
    TracedWire wire(clock, nuri::protocol(), nuri_line, 1'000'000, 100us, settings, std::move(faults), nuri_answer);
    const auto choice = nuri_choice();
    return run_serial(clock, wire, choice, count, [](const auto& on, const auto& asked, const auto& result, Tally& t) {
        judge_framed(on, asked, result, nuri_number, t);
    });
}

} // namespace sinew::tests
