#include "sinew/bus/agree.hpp"
#include "sinew/family/nuri/lines.hpp"
#include "sinew/family/rmd/lines.hpp"
#include "tests/bus/traced_wire.hpp"

#include <cstdlib>
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <map>

/// Whatever happens on the wire, a call returns the data of the device and the message that it asked, and says so when
/// they may be older. Every fault is on; the exchanges are as many as SINEW_EXCHANGES says.
namespace sinew::tests {
namespace {

using namespace std::chrono_literals;

std::uint64_t exchanges()
{
    const char* given = std::getenv("SINEW_EXCHANGES");
    return given != nullptr ? std::strtoull(given, nullptr, 10) : 30'000;
}

constexpr std::uint64_t seed = 20'25;

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
    std::uint64_t too_late = 0;   ///< returned after its deadline: never

    void print(std::string_view name) const
    {
        fmt::print(
            "{:<28} {:>9} asked {:>9} right {:>7} errors {:>6} marked {:>5} damaged {:>4} by mistake | {} foreign "
            "{} unmarked {} too late\n",
            name, asked, right, none, marked, damaged, by_mistake, foreign, unmarked, too_late);
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
void check_waits(const bus::Bus& bus, const Ask& ask, TimePoint began, Tally& tally)
{
    tally.too_late += bus.clock().now() - began > bus.conversation().longest(ask.requests);
    for (const auto& result : ask.results)
        tally.too_late += result.good && result.at > result.deadline;
}

// ---- serial families ----

/// Judges a bare reply by where its bytes came from.
void judge_bare(const TracedWire& wire, const wire::Request& asked, const bus::Result& result, Tally& tally)
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
        ++(result.possibly_older ? tally.marked : tally.unmarked);
    else if (whole)
        ++tally.right;
    else {
        ++tally.damaged;
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
        ++(result.possibly_older ? tally.marked : tally.unmarked);
    else
        ++tally.right;
}

template <class Judge>
Tally run_serial(WireClock& clock, TracedWire& wire, std::span<const wire::Request> choice, std::uint64_t count,
                 Judge&& judge)
{
    Tally tally;
    sim::Dice dice;
    dice.seed(seed);
    wire.seed(seed + 1);
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
    return tally;
}

constexpr bus::Settings settings{.margin_at_first = 5ms};
constexpr TracedFaults all_faults{
    .bytes = {.flip_bit = 1e-3, .drop_byte = 1e-3, .add_byte = 1e-3, .delay_reply = 5e-3, .reply_delay = 50ms},
    .cut_cable = 2e-4,
    .dead_device = 2e-4};

constexpr wire::Profile sam_line{.name = "sam", .messages = sam::manual_messages};
constexpr wire::Profile nuri_line{.name = "nuri", .messages = nuri::manual_messages};

std::optional<wire::Frame> sam_answer(const wire::MessageInfo& message, int id, std::uint32_t number)
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

std::vector<wire::Request> sam_choice(Duration response)
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

Tally run_sam(std::uint64_t count, TracedFaults faults, bus::Settings with = settings)
{
    WireClock clock;
    TracedWire wire(clock, sam::protocol(), sam_line, 1'500'000, 50us, with, faults,
                    [](const wire::MessageInfo& message, int id, std::uint32_t number) {
                        if (&message == &wire::info_of<sam::Ping>)
                            return std::optional(
                                *wire::encode_reply<sam::Ping>(id, {.id = static_cast<std::uint8_t>(id)}));
                        return sam_answer(message, id, number);
                    });
    const auto choice = sam_choice(50us);
    return run_serial(clock, wire, choice, count, judge_bare);
}

std::optional<wire::Frame> nuri_answer(const wire::MessageInfo& message, int id, std::uint32_t number)
{
    const auto low = static_cast<std::uint16_t>(number % 65'000);
    const auto high = static_cast<std::uint16_t>(number / 65'000);
    if (&message == &wire::info_of<nuri::RequestPositionFeedback>)
        return *wire::encode_reply<nuri::RequestPositionFeedback>(id, {.position = low, .speed = high});
    if (&message == &wire::info_of<nuri::RequestSpeedFeedback>)
        return *wire::encode_reply<nuri::RequestSpeedFeedback>(id, {.speed = low, .position = high});
    return std::nullopt;
}

std::uint32_t nuri_number(const wire::MessageInfo& message, const wire::Frame& frame)
{
    if (&message == &wire::info_of<nuri::RequestPositionFeedback>)
        if (const auto reply = wire::decode_reply<nuri::RequestPositionFeedback>(frame))
            return reply->message.speed * 65'000U + reply->message.position;
    if (const auto reply = wire::decode_reply<nuri::RequestSpeedFeedback>(frame))
        return reply->message.position * 65'000U + reply->message.speed;
    return 0;
}

Tally run_nuri(std::uint64_t count, TracedFaults faults)
{
    WireClock clock;
    TracedWire wire(clock, nuri::protocol(), nuri_line, 1'000'000, 100us, settings, faults, nuri_answer);
    std::vector<wire::Request> choice;
    for (int id = 0; id < 8; ++id) {
        choice.push_back(*wire::make_request(id, nuri::RequestPositionFeedback{}, {}, 100us));
        choice.push_back(*wire::make_request(id, nuri::RequestSpeedFeedback{}, {}, 100us));
    }
    choice.push_back(*wire::make_request(255, nuri::SetControlOnOff{.control = nuri::Control::off}));
    return run_serial(clock, wire, choice, count, [](const auto& on, const auto& asked, const auto& result, Tally& t) {
        judge_framed(on, asked, result, nuri_number, t);
    });
}

TEST(Matching, OfSamsBareRepliesNeverReturnsAnothersData)
{
    const Tally tally = run_sam(exchanges() / 4, all_faults);
    tally.print("sam");
    tally.expect_none_wrong();
    EXPECT_GT(tally.right, tally.asked / 2);
}

TEST(Matching, OfSamsBareRepliesNeverReturnsAnothersDataBehindAnAdapterThatHearsItself)
{
    TracedFaults faults = all_faults;
    faults.echo = true;
    const Tally tally = run_sam(exchanges() / 8, faults);
    tally.print("sam, echo");
    tally.expect_none_wrong();
    EXPECT_GT(tally.right, tally.asked / 2);
}

TEST(Matching, OfNuriNeverReturnsAnothersData)
{
    // Often late by little more than the margin: so the answer to a request often comes while it is asked again.
    TracedFaults faults = all_faults;
    faults.bytes.delay_reply = 5e-2;
    faults.bytes.reply_delay = 8ms;
    const Tally tally = run_nuri(exchanges() / 4, faults);
    tally.print("nuri");
    tally.expect_none_wrong();
    EXPECT_GT(tally.right, tally.asked / 2);
    EXPECT_GT(tally.marked, 0U) << "the test never saw an older answer, so it proves nothing about them";
}

TEST(Matching, OfNuriNeverReturnsAnothersDataBehindAnAdapterThatHearsItself)
{
    TracedFaults faults = all_faults;
    faults.echo = true;
    const Tally tally = run_nuri(exchanges() / 8, faults);
    tally.print("nuri, echo");
    tally.expect_none_wrong();
    EXPECT_GT(tally.right, tally.asked / 2);
}

// ---- RMD ----

rmd::MotorState rmd_state(std::uint32_t number)
{
    rmd::MotorState state{.temperature = 30};
    state.speed = static_cast<std::int16_t>(number & 0x7FFF);
    state.encoder = static_cast<std::uint16_t>(number >> 15);
    return state;
}

/// The number stands in the last four bytes, whichever message it is.
std::uint32_t rmd_number(const wire::MessageInfo& message, const wire::Frame& frame)
{
    if (&message == &wire::info_of<rmd::ReadMultiTurnAngle>) {
        const auto reply = wire::decode_reply<rmd::ReadMultiTurnAngle>(frame);
        return reply ? static_cast<std::uint32_t>(reply->message.angle) : 0;
    }
    return static_cast<std::uint32_t>(frame.data[4] | frame.data[5] << 8) |
           static_cast<std::uint32_t>(frame.data[6] | frame.data[7] << 8) << 15;
}

TEST(Matching, OfRmdNeverReturnsAnothersData)
{
    WireClock clock;
    CanRig rig(clock, 1'000'000, settings);
    std::vector<Given> given(1);
    for (int id = 1; id <= 8; ++id)
        rig.add(id, [&, id](const wire::Frame& request, TimePoint at) -> std::optional<sim::Answer> {
            static constexpr wire::Profile line{.name = "rmd", .messages = rmd::manual_messages};
            const auto* message = rmd::protocol().identify(request, wire::Direction::request, line);
            const auto number = static_cast<std::uint32_t>(given.size());
            std::optional<wire::Frame> frame;
            if (message == &wire::info_of<rmd::ReadMultiTurnAngle>)
                frame = *wire::encode_reply<rmd::ReadMultiTurnAngle>(id, {.angle = number});
            else if (message == &wire::info_of<rmd::ReadStatus2>)
                frame = *wire::encode_reply<rmd::ReadStatus2>(id, rmd_state(number));
            else if (message == &wire::info_of<rmd::TorqueClosedLoop> ||
                     (message == &wire::info_of<rmd::MultiMotorTorque> && id <= 4))
                frame = *wire::encode_reply<rmd::TorqueClosedLoop>(id, rmd_state(number));
            if (!frame)
                return std::nullopt;
            given.push_back({id, message, false, at, *frame});
            return sim::Answer{*frame, 100us};
        });
    std::vector<wire::Request> choice;
    for (int id = 1; id <= 8; ++id) {
        choice.push_back(*wire::make_request(id, rmd::ReadMultiTurnAngle{}, {}, 100us));
        choice.push_back(*wire::make_request(id, rmd::ReadStatus2{}, {}, 100us));
        choice.push_back(*wire::make_request(id, rmd::TorqueClosedLoop{}, {}, 100us));
    }
    choice.push_back(*wire::make_request(0, rmd::MultiMotorTorque{}, {}, 100us));
    rig.wire.faults() = {.flip_bit = 1e-3, .drop_byte = 1e-3, .delay_reply = 5e-3};
    rig.wire.seed(seed);
    sim::Dice dice;
    dice.seed(seed);
    Tally tally;
    Ask ask;
    const std::uint64_t count = exchanges() / 4;
    while (tally.asked < count) {
        ask.requests.clear();
        for (unsigned i = 1 + dice.pick(8); i > 0; --i)
            ask.requests.push_back(choice[dice.pick(static_cast<unsigned>(choice.size()))]);
        ask.results.resize(ask.requests.size());
        rig.wire.faults().reply_delay = 50us * (1 + dice.pick(1000));
        if (dice.falls(5e-4)) { // at most one is unplugged, half of the time none
            const unsigned out = dice.pick(16);
            for (std::size_t i = 0; i < rig.stations.size(); ++i)
                rig.stations[i]->is_plugged = i != out;
            rig.wire.refresh();
        }
        const TimePoint began = clock.now();
        (void)rig.bus->exchange(ask.requests, ask.results);
        check_waits(*rig.bus, ask, began, tally);
        for (std::size_t i = 0; i < ask.results.size(); ++i) {
            const bus::Result& result = ask.results[i];
            const wire::Request& asked = ask.requests[i];
            ++tally.asked;
            tally.none += !result.good;
            for (std::size_t n = 0; result.good && n < result.reply_count; ++n) {
                const std::uint32_t number = rmd_number(*asked.message, result.replies[n]);
                const bool known = number != 0 && number < given.size() && given[number].frame == result.replies[n];
                const bool to_several = asked.message->request.layout->can_fixed;
                if (!known || (!to_several && given[number].id != asked.id) ||
                    given[number].message->reply.opcode != asked.message->reply.opcode)
                    ++tally.foreign;
                else if (given[number].heard_at < result.sent_at)
                    ++(result.possibly_older ? tally.marked : tally.unmarked);
                else
                    ++tally.right;
            }
        }
        if (dice.falls(0.3))
            clock.wait({}, clock.now() + Duration(dice.pick(100'000)) * 20);
    }
    tally.print("rmd");
    tally.expect_none_wrong();
    EXPECT_GT(tally.right, tally.asked / 2);
    EXPECT_GT(tally.marked, 0U);
}

// ---- what is left ----

/// Measured beside computed for one kind of fault, large enough to be seen.
void print_risk(std::string_view what, const Tally& tally, std::uint64_t wrong, double computed)
{
    fmt::print("residual {:<58} measured {:.2e} computed {:.2e}\n", what,
               static_cast<double>(wrong) / static_cast<double>(tally.asked), computed);
}

/// A reply of two bytes is wrong when a bit of it flips, or when noise comes between its bytes.
double computed_bare(double flip, double add)
{
    return 1.0 - (1.0 - flip) * (1.0 - flip) * (1.0 - add);
}

TEST(ResidualRisk, OfDamagedBareRepliesIsWhatIsComputed)
{
    constexpr double often = 5e-3;
    const std::uint64_t count = exchanges() / 8;
    // Of 33 requests 32 are answered.
    constexpr double answered = 32.0 / 33.0;
    const Tally flipped = run_sam(count, {.bytes = {.flip_bit = often}});
    print_risk("sam, a bit of a reply flips", flipped, flipped.damaged, answered * computed_bare(often, 0));
    EXPECT_NEAR(static_cast<double>(flipped.damaged) / static_cast<double>(count), computed_bare(often, 0),
                0.5 * computed_bare(often, 0));
    const Tally added = run_sam(count, {.bytes = {.add_byte = often}});
    print_risk("sam, noise within a reply", added, added.damaged, answered * computed_bare(0, often));
    bus::Settings twice = settings;
    twice.double_read = true;
    const Tally doubled = run_sam(count, {.bytes = {.flip_bit = often}}, twice);
    // Commands are not asked twice: half of the requests. Of the reads those go wrong in which both answers do alike.
    const double both = computed_bare(often, 0) * often / 8;
    print_risk("sam, double read, a bit flips: far off, commands included", doubled, doubled.far_off,
               flipped.asked == 0
                   ? 0.0
                   : 0.5 * static_cast<double>(flipped.far_off) / static_cast<double>(flipped.asked) + both);
    EXPECT_LT(doubled.far_off, flipped.far_off);
}

TEST(ResidualRisk, OfDamagedFramesIsTwoFlipsThatTheChecksumCannotTell)
{
    constexpr double often = 2e-2;
    const std::uint64_t count = exchanges() / 8;
    const Tally flipped = run_nuri(count, {.bytes = {.flip_bit = often}});
    // Two of the seven bytes that are not looked at otherwise (six of payload, the checksum); the same bit of both, one
    // up and one down, or bit 7.
    constexpr double pairs = 21.0;
    constexpr double alike = 1.0 / 8.0 * (7.0 / 8.0 * 0.5 + 1.0 / 8.0);
    print_risk("nuri, two bits of a frame flip", flipped, flipped.damaged, 16.0 / 17.0 * pairs * often * often * alike);
}

} // namespace
} // namespace sinew::tests
