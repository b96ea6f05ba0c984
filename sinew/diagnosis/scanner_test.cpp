#include "sinew/diagnosis/scanner.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/diagnosis/probes.hpp"
#include "sinew/wire/values.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>

/// What a scan puts on a wire, looked at by everybody who may hear it: as another family, and at another bit rate.
namespace sinew::diagnosis {
namespace {

using wire::Direction;

/// Everything that the devices of a family could take for a request in a stream of bytes, whatever their firmware line
/// and whenever they think that the line fell silent.
void expect_nothing_but_reads(const Family& listener, std::vector<std::uint8_t> bytes, const std::string& heard_from)
{
    for (const bool silent : {false, true}) {
        std::span<const std::uint8_t> rest = bytes;
        while (!rest.empty()) {
            const auto scan = listener.protocol->find_request(rest, silent);
            if (scan.size == 0)
                break;
            wire::Frame frame{.size = static_cast<std::uint8_t>(scan.size)};
            std::copy_n(rest.begin() + static_cast<std::ptrdiff_t>(scan.skip), scan.size, frame.data.begin());
            rest = rest.subspan(scan.skip + scan.size);
            for (const auto* line : listener.profiles) {
                const auto* message = listener.protocol->identify(frame, Direction::request, *line);
                if (message == nullptr)
                    continue;
                EXPECT_EQ(message->info.access, wire::Access::read)
                    << heard_from << " reads as " << message->name() << " of " << listener.name << ": "
                    << to_hex(frame.bytes());
            }
        }
    }
}

/// What a scan sends to all ids of a family at a bit rate, in order.
std::vector<wire::Frame> sent_at(const Family& family, std::uint32_t bit_rate)
{
    Audience audience;
    std::vector<wire::Frame> out;
    for (auto id = family.ids.low; id <= family.ids.high; ++id) {
        const auto request = safe_one(ways_to_ask(family, static_cast<int>(id)), audience, bit_rate);
        EXPECT_TRUE(request.has_value()) << family.name << " id " << id << " at " << bit_rate << " cannot be asked";
        if (!request)
            continue;
        audience.hear(request->frame, bit_rate);
        out.push_back(request->frame);
    }
    return out;
}

std::vector<const Family*> serial_families()
{
    std::vector<const Family*> out;
    for (const auto* family : families())
        if (!family->can)
            out.push_back(family);
    return out;
}

/// The line while frames are sent at `rate` with `gap` of silence after each: the times at which its level changes,
/// beginning with a fall. It is high before and after.
struct Waveform {
    std::vector<double> edges;

    void send(const wire::Frame& frame, double rate, double gap)
    {
        for (const auto byte : frame.bytes()) {
            level(false, 1.0 / rate);
            for (int bit = 0; bit < 8; ++bit)
                level((byte >> bit & 1) != 0, 1.0 / rate);
            level(true, 1.0 / rate);
        }
        level(true, gap);
    }

    /// The level at a time, for times that do not go back before `from`, an edge that is known to be earlier.
    bool at(double time, std::size_t& from) const
    {
        while (from < edges.size() && edges[from] <= time)
            ++from;
        return from % 2 == 0;
    }

private:
    void level(bool high, double duration)
    {
        if (high != high_)
            edges.push_back(now_);
        high_ = high;
        now_ += duration;
    }

    bool high_ = true;
    double now_ = 1.0;
};

/// What a UART at `rate` makes of it. It looks for a fall, checks the start bit in its middle and samples each bit in
/// its own. A byte without its stop bit is dropped or, as some do, delivered.
std::vector<std::uint8_t> receive(const Waveform& line, double rate, double shift, bool deliver_broken)
{
    std::vector<std::uint8_t> out;
    const double bit = 1.0 / rate;
    double ready = 0.0;
    for (std::size_t i = 0; i < line.edges.size(); i += 2) { // every second edge is a fall
        const double fall = line.edges[i];
        std::size_t edge = i;
        if (fall < ready || line.at(fall + (0.5 + shift) * bit, edge))
            continue;
        unsigned byte = 0;
        for (int n = 0; n < 8; ++n)
            byte |= static_cast<unsigned>(line.at(fall + (1.5 + n + shift) * bit, edge)) << n;
        ready = fall + (9.5 + shift) * bit;
        if (line.at(ready, edge) || deliver_broken)
            out.push_back(static_cast<std::uint8_t>(byte));
    }
    return out;
}

TEST(Probe, IsAReadOnEveryFirmwareLineOfItsOwnFamily)
{
    for (const auto* family : families())
        for (auto id = family->ids.low; id <= family->ids.high; ++id)
            for (const auto& way : ways_to_ask(*family, static_cast<int>(id)))
                for (const auto* line : family->profiles) {
                    const auto* message = family->protocol->identify(way.frame, Direction::request, *line);
                    ASSERT_NE(message, nullptr) << line->name << " " << way.message->name();
                    EXPECT_EQ(message->info.access, wire::Access::read) << line->name;
                    EXPECT_FALSE(message->info.moves) << line->name;
                    EXPECT_TRUE(wire::decode(*message, Direction::request, way.frame, line->options).has_value());
                }
}

TEST(Probe, IsNothingButAReadToADeviceThatHearsItAtAnotherBitRateOrAsAnotherFamily)
{
    // Not those that the audience itself is made of.
    constexpr double clock_errors[] = {-0.0177, 0.0, 0.0071};
    constexpr double shifts[] = {-0.04, 0.03};
    for (const auto* speaker : serial_families())
        for (const auto& rate : speaker->bit_rates) {
            Waveform line;
            for (const auto& frame : sent_at(*speaker, rate.bps))
                line.send(frame, rate.bps, 0.02);
            for (const auto* listener : serial_families())
                for (const auto& heard : listener->bit_rates)
                    for (const double error : clock_errors)
                        for (const double shift : shifts)
                            for (const bool broken : {false, true})
                                expect_nothing_but_reads(
                                    *listener, receive(line, heard.bps * (1.0 + error), shift, broken),
                                    fmt::format("{} at {} heard at {}", speaker->name, rate.bps, heard.bps));
        }
}

TEST(Model, OfEverySamCanBeAskedForAtEveryBitRate)
{
    const auto& sam = *find_family("sam");
    for (const auto& rate : sam.bit_rates)
        for (auto id = sam.ids.low; id <= sam.ids.high; ++id)
            EXPECT_TRUE(safe_one(ways_to_ask_model(sam, static_cast<int>(id)), Audience{}, rate.bps))
                << id << " at " << rate.bps;
}

TEST(Audience, HearsAPositionCommandInAPlainPingAtTwoThirdsOfTheBitRate)
{
    const auto ping = find_family("sam")->protocol->probe(1);
    ASSERT_TRUE(ping.has_value());
    bool harmless_to_all = true;
    for (int id = 0; id <= 254; ++id)
        harmless_to_all =
            harmless_to_all && Audience{}.harmless(find_family("sam")->protocol->probe(id)->frame, 1'000'000);
    EXPECT_FALSE(harmless_to_all);
    EXPECT_TRUE(Audience{}.harmless(ping->frame, 115'200));
}

TEST(Audience, HearsWhatAUartHears)
{
    const auto ping = find_family("sam")->protocol->probe(77);
    ASSERT_TRUE(ping.has_value());
    for (const double rate : {9600.0, 57600.0, 115200.0, 120000.0, 230400.0}) {
        constexpr double shift = 0.01;
        Waveform line;
        line.send(ping->frame, 115200, 0.01);
        std::vector<std::uint8_t> heard;
        std::vector<HeardByte> arrived;
        hear_at(LineLevels(ping->frame.bytes()), 115200, {rate, shift}, arrived);
        for (const auto& byte : arrived)
            heard.push_back(byte.value);
        EXPECT_EQ(heard, receive(line, rate, shift, true)) << rate;
    }
}

TEST(Uart, HearsWhatWasSentAtItsOwnRate)
{
    const auto* sam = find_family("sam");
    ASSERT_NE(sam, nullptr);
    Waveform line;
    std::vector<std::uint8_t> sent;
    for (const auto& frame : sent_at(*sam, 115200)) {
        line.send(frame, 115200, 0.0);
        sent.insert(sent.end(), frame.bytes().begin(), frame.bytes().end());
    }
    EXPECT_EQ(receive(line, 115200, 0.0, false), sent);
    EXPECT_NE(receive(line, 57600, 0.0, true), sent);
}

TEST(Passes, BeginWithLowIdsAtTheRateOfTheLinkAndAtThoseOfDelivery)
{
    const auto all = passes({}, false, 115200);
    ASSERT_GT(all.size(), 8U);
    const auto expect = [&](std::size_t i, std::string_view family, std::uint32_t rate, wire::Range ids) {
        EXPECT_EQ(all[i].family->name, family) << i;
        EXPECT_EQ(all[i].bit_rate, rate) << i;
        EXPECT_EQ(all[i].ids, ids) << i;
    };
    expect(0, "sam", 115200, {0, 7});
    expect(1, "nuri", 115200, {0, 7});
    expect(2, "sam", 1'500'000, {0, 7});
    expect(3, "nuri", 9600, {0, 7});
    expect(4, "sam", 115200, {8, 254});
    expect(7, "nuri", 9600, {8, 254});
    EXPECT_TRUE(all[8].likely);
}

TEST(Passes, LeaveOutNoIdAtNoRateAndNameNoneTwice)
{
    for (const auto* family : serial_families()) {
        std::size_t ids = 0;
        for (const auto& pass : passes({.families = {family}}, false, 9600))
            ids += static_cast<std::size_t>(pass.ids.high - pass.ids.low + 1);
        EXPECT_EQ(ids, family->bit_rates.size() * static_cast<std::size_t>(family->ids.high - family->ids.low + 1));
    }
}

TEST(ExpectedTime, OfEveryBitRateAndIdOfNuriIsAboutSevenMinutes)
{
    const auto s = seconds(expected_time(passes({.families = {find_family("nuri")}}, false, 9600)));
    std::printf("all of nuri: %.0f s\n", s);
    EXPECT_LT(s, 7.5 * 60);
}

TEST(ExpectedTime, OfTheLikelyPlacesIsLessThanThreeSeconds)
{
    for (const std::uint32_t rate : {9600, 115'200, 1'500'000}) {
        const auto all = passes({}, false, rate);
        const Duration sum = expected_time(likely_places(all));
        std::printf("likely places from %u: %.2f s\n", rate, seconds(sum));
        EXPECT_LT(seconds(sum), 3.0) << rate;
    }
}

TEST(LikelyPlaces, AreNotAllPlacesWhereOnlyLowIdsAreLookedAt)
{
    const auto all = passes({.ids = wire::Range{1, 3}}, false, 9600);
    const auto likely = likely_places(all);
    ASSERT_EQ(likely.size(), 3U) << "SAM and Nuri as delivered, and the rate of the link";
    std::vector<std::string> at;
    for (const auto& pass : likely)
        at.push_back(fmt::format("{} {}", pass.family->name, pass.bit_rate));
    EXPECT_EQ(at, (std::vector<std::string>{"sam 9600", "nuri 9600", "sam 1500000"}));
    EXPECT_LT(seconds(expected_time(likely)), 1.0);
    EXPECT_GT(seconds(expected_time(all)), 5.0);
}

TEST(LikelyPlaces, AreAllWhereOneRateIsLookedAt)
{
    const auto all = passes({.bit_rate = 9600, .ids = wire::Range{1, 3}}, false, 9600);
    EXPECT_EQ(likely_places(all).size(), all.size());
}

TEST(Passes, KeepToWhatWasAskedFor)
{
    const auto all =
        passes({.families = {find_family("nuri")}, .bit_rate = 38400, .ids = wire::Range{3, 12}}, false, 9600);
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[0].bit_rate, 38400U);
    EXPECT_EQ(all[0].ids, (wire::Range{3, 10}));
    EXPECT_EQ(all[1].ids, (wire::Range{11, 12}));
}

TEST(Passes, StayAtTheRateOfACanBus)
{
    const auto all = passes({}, true, 500'000);
    ASSERT_EQ(all.size(), 1U);
    EXPECT_EQ(all[0].family->name, "rmd");
    EXPECT_EQ(all[0].bit_rate, 500'000U);
}

} // namespace
} // namespace sinew::diagnosis
