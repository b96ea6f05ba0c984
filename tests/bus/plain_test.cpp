#include "tests/bus/rig.hpp"
#include "tests/support/random.hpp"

#include <gtest/gtest.h>

/// One request with one answer takes a way of its own through the bus, unless a tap looks on. Whatever comes from the
/// wire, both ways end in the same instant with the same result and the same counts.
namespace sinew::tests {
namespace {

using namespace std::chrono_literals;

/// What one exchange came to.
struct Outcome {
    bool good = false;
    bool possibly_older = false;
    int tries = 0;
    Errc code{};
    wire::Frame answer;
    TimePoint sent_at, deadline, at, now;
    Duration margin;
    bus::Counters total, own;
};

bool operator==(const bus::Counters& a, const bus::Counters& b)
{
    return a.requests == b.requests && a.replies == b.replies && a.timeouts == b.timeouts && a.retries == b.retries &&
           a.late == b.late && a.strays == b.strays && a.bad_checksums == b.bad_checksums && a.echoes == b.echoes &&
           a.quarantines == b.quarantines && a.round_trips == b.round_trips;
}

bool operator==(const Outcome& a, const Outcome& b)
{
    return a.good == b.good && a.possibly_older == b.possibly_older && a.tries == b.tries && a.code == b.code &&
           a.answer == b.answer && a.sent_at == b.sent_at && a.deadline == b.deadline && a.at == b.at &&
           a.now == b.now && a.margin == b.margin && a.total == b.total && a.own == b.own;
}

Outcome exchange(bus::Bus& bus, const wire::Request& request)
{
    bus::Result result;
    (void)bus.exchange({&request, 1}, {&result, 1});
    return {.good = result.good,
            .possibly_older = result.possibly_older,
            .tries = result.tries,
            .code = result.good ? Errc{} : result.error.code,
            .answer = result.good ? result.answer() : wire::Frame{},
            .sent_at = result.sent_at,
            .deadline = result.deadline,
            .at = result.at,
            .now = bus.clock().now(),
            .margin = bus.conversation().margin(),
            .total = bus.conversation().counters(),
            .own = bus.conversation().counters(request.id)};
}

/// The right answer as a rule; or none, late, torn, flipped, or that of another device.
std::optional<sim::Answer> spoil(wire::Frame right, std::uint64_t dice, bool is_can)
{
    sim::Answer answer{right, 100us};
    switch (dice % 12) {
    case 0:
        return {};
    case 1:
    case 2:
        answer.delay = Duration{static_cast<std::int64_t>(dice >> 8) % 90'000'000};
        break;
    case 3:
        answer.frame.data[(dice >> 8) % right.size] ^= static_cast<std::uint8_t>(1U << (dice >> 16) % 8);
        break;
    case 4:
        if (is_can)
            ++answer.frame.can_id;
        else
            answer.frame.size = static_cast<std::uint8_t>(1 + (dice >> 8) % right.size);
        break;
    case 5:
        answer.delay = 0us;
        break;
    default:
        break;
    }
    return answer;
}

/// `count` exchanges; on either way the wire and its devices do the same.
template <class Rig>
std::vector<Outcome> run(Rig& rig, bool long_way, std::span<const wire::Request> choice, int count, std::uint64_t seed)
{
    if (long_way)
        rig.bus->set_tap([](const bus::Tapped&) {});
    std::mt19937_64 engine(seed);
    std::vector<Outcome> out;
    for (int i = 0; i < count; ++i)
        out.push_back(exchange(*rig.bus, choice[engine() % choice.size()]));
    return out;
}

void expect_same(const std::vector<Outcome>& plain, const std::vector<Outcome>& other, std::uint64_t seed)
{
    ASSERT_EQ(plain.size(), other.size());
    for (std::size_t i = 0; i < plain.size(); ++i)
        ASSERT_TRUE(plain[i] == other[i])
            << "exchange " << i << " of seed " << seed << ": " << plain[i].good << other[i].good << ", "
            << to_word(plain[i].code) << ' ' << to_word(other[i].code) << ", " << (plain[i].now - other[i].now).count()
            << " ns apart";
}

/// So impatient that late answers come in the midst of later exchanges.
bus::Settings impatient(bool paced)
{
    return {.margin_at_first = 3ms, .margin_least = 2ms, .late_max = 3ms, .read_retries = 1, .paced = paced};
}

constexpr int rounds = 300;
constexpr int each = 25;

template <class M>
void add_choice(std::vector<wire::Request>& choice, int id, const M& message)
{
    choice.push_back(*wire::make_request(id, message, {}, 200us));
}

/// A wire behind an adapter that hands over what it heard in one piece, so that an answer comes whole.
class PiecesRig final : public Port, private link::ByteSink
{
public:
    using Answer = std::function<std::optional<sim::Answer>(std::span<const std::uint8_t> heard)>;

    PiecesRig(WireClock& clock, const wire::Protocol& protocol, std::uint32_t bit_rate, bus::Settings settings,
              Answer answer)
        : clock_(clock), bit_rate_(bit_rate), answer_(std::move(answer))
    {
        auto made = std::make_unique<link::VirtualByteLink>(clock, static_cast<link::ByteSink&>(*this), bit_rate);
        link_ = made.get();
        clock.watch(*this);
        bus.emplace("pieces", link::AnyLink{std::unique_ptr<link::ByteLink>{std::move(made)}}, clock, protocol,
                    settings);
    }
    TimePoint next_event() const override
    {
        TimePoint next = TimePoint::max();
        for (const auto& piece : pieces_)
            next = std::min(next, piece.at);
        return next;
    }
    void run_until(TimePoint until) override
    {
        for (TimePoint next = next_event(); next <= until; next = next_event()) {
            const auto piece = std::ranges::find(pieces_, next, &Piece::at);
            link_->deliver(piece->frame.bytes(), piece->at);
            pieces_.erase(piece);
        }
    }
    std::optional<TimePoint> next_arrival() const override { return link_->next_arrival(); }

    std::optional<bus::Bus> bus;

private:
    struct Piece {
        wire::Frame frame;
        TimePoint at;
    };
    void on_write(std::span<const std::uint8_t> bytes, std::uint32_t) override
    {
        const auto answer = answer_(bytes);
        if (!answer)
            return;
        const auto bits = 10 * static_cast<std::int64_t>(bytes.size() + answer->frame.size);
        // No delay at all stands for what was on its way before the request.
        const Duration after = answer->delay == Duration{} ? 1us : bit_time(bits, bit_rate_) + answer->delay;
        pieces_.push_back({answer->frame, clock_.now() + after});
    }

    WireClock& clock_;
    std::uint32_t bit_rate_;
    Answer answer_;
    link::VirtualByteLink* link_ = nullptr;
    std::vector<Piece> pieces_;
};

/// The same with whole answers: those of both devices come from one place.
template <class Reply>
void compare_pieces(const wire::Protocol& protocol, std::span<const wire::Request> choice, Reply&& reply, bool paced)
{
    for (std::uint64_t round = 0; round < rounds; ++round) {
        const std::uint64_t seed = test::seed() + round;
        int good = 0;
        const auto way = [&](bool long_way) {
            WireClock clock;
            std::mt19937_64 engine(seed + 1);
            PiecesRig rig(clock, protocol, 9600, impatient(paced), [&](std::span<const std::uint8_t> heard) {
                const auto asked = std::ranges::find(choice, wire::Frame::of(heard), &wire::Request::frame);
                const auto dice = engine();
                return asked == choice.end() ? std::nullopt : spoil(reply(asked->frame, asked->id), dice, false);
            });
            auto outcomes = run(rig, long_way, choice, each, seed);
            good += static_cast<int>(std::ranges::count(outcomes, true, &Outcome::good));
            return outcomes;
        };
        expect_same(way(false), way(true), seed);
        EXPECT_GT(good, 0);
        if (testing::Test::HasFailure())
            return;
    }
}

/// `reply(request, id)` is the right answer.
template <class Reply>
void compare_serial(const wire::Protocol& protocol, std::uint32_t bit_rate, std::span<const wire::Request> choice,
                    Reply&& reply, bool paced)
{
    for (std::uint64_t round = 0; round < rounds; ++round) {
        const std::uint64_t seed = test::seed() + round;
        const auto way = [&](bool long_way) {
            WireClock clock;
            SerialRig rig(clock, protocol, bit_rate, impatient(paced));
            std::mt19937_64 engine(seed + 1);
            for (const int id : {3, 4})
                rig.add(id, [&, id](const wire::Frame& heard, TimePoint) -> std::optional<sim::Answer> {
                    return spoil(reply(heard, id), engine(), false);
                });
            return run(rig, long_way, choice, each, seed);
        };
        expect_same(way(false), way(true), seed);
        if (testing::Test::HasFatalFailure())
            return;
    }
}

TEST(Plain, SamIsTheLongWay)
{
    std::vector<wire::Request> choice;
    for (const int id : {3, 4}) {
        add_choice(choice, id, sam::QuickReadStatus{});
        add_choice(choice, id, sam::Ping{});
    }
    const auto reply = [](const wire::Frame& heard, int id) {
        const auto asked = *wire::make_request(id, sam::Ping{});
        if (heard == asked.frame)
            return *wire::encode_reply<sam::Ping>(id, {.id = static_cast<std::uint8_t>(id)});
        return *wire::encode_reply<sam::QuickReadStatus>(id, {.load = 1, .position = static_cast<std::uint8_t>(id)});
    };
    for (const bool paced : {true, false})
        compare_serial(sam::protocol(), 9600, choice, reply, paced);
    for (const bool paced : {true, false})
        compare_pieces(sam::protocol(), choice, reply, paced);
}

TEST(Plain, NuriIsTheLongWay)
{
    std::vector<wire::Request> choice;
    for (const int id : {3, 4}) {
        add_choice(choice, id, nuri::RequestPositionFeedback{});
        add_choice(choice, id, nuri::RequestPing{});
    }
    const auto reply = [](const wire::Frame& heard, int id) {
        if (heard.data[5] == wire::info_of<nuri::RequestPing>.request.opcode)
            return *wire::encode_reply<nuri::RequestPing>(id, {});
        return *wire::encode_reply<nuri::RequestPositionFeedback>(id, {.position = 4711});
    };
    for (const bool paced : {true, false})
        compare_serial(nuri::protocol(), 9600, choice, reply, paced);
    for (const bool paced : {true, false})
        compare_pieces(nuri::protocol(), choice, reply, paced);
}

TEST(Plain, RmdIsTheLongWay)
{
    std::vector<wire::Request> choice;
    for (const int id : {3, 4}) {
        add_choice(choice, id, rmd::ReadStatus2{});
        add_choice(choice, id, rmd::TorqueClosedLoop{.iq = 5});
    }
    for (std::uint64_t round = 0; round < rounds; ++round) {
        const std::uint64_t seed = test::seed() + round;
        const auto way = [&](bool long_way) {
            WireClock clock;
            CanRig rig(clock, 20'000, impatient(true));
            std::mt19937_64 engine(seed + 1);
            for (const int id : {3, 4})
                rig.add(id, [&, id](const wire::Frame& heard, TimePoint) -> std::optional<sim::Answer> {
                    const bool reads = heard.data[0] == wire::info_of<rmd::ReadStatus2>.request.opcode;
                    return spoil(reads ? *wire::encode_reply<rmd::ReadStatus2>(id, {})
                                       : *wire::encode_reply<rmd::TorqueClosedLoop>(id, {}),
                                 engine(), true);
                });
            return run(rig, long_way, choice, each, seed);
        };
        expect_same(way(false), way(true), seed);
        if (HasFatalFailure())
            return;
    }
}

} // namespace
} // namespace sinew::tests
