#include "sinew/diagnosis/scanner.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/sim/simulator.hpp"

#include <cstdio>
#include <fmt/format.h>
#include <gtest/gtest.h>

/// Scans of simulated wires in virtual time: what they find, and that they take as long as they say.
namespace sinew {
namespace {

using diagnosis::Found;
using diagnosis::Pass;

struct Scanned {
    std::vector<Found> found;
    Duration took{};
    Duration predicted{};
};

Scanned scan(std::string_view robot, std::uint32_t link_rate, bool all = false,
             std::vector<const Family*> families = {})
{
    const auto file = config::parse_robot_file(robot, "scan.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    auto simulator = sim::Simulator::make(*file);
    EXPECT_TRUE(simulator) << to_sentence(simulator.error());
    auto link = (*simulator)->open("");
    EXPECT_TRUE(link);
    auto& clock = (*simulator)->clock();
    diagnosis::Line line(std::move(*link), clock);
    EXPECT_TRUE(line.set_bit_rate(link_rate));
    diagnosis::Scanner scanner(line);
    const auto passes = diagnosis::passes({.families = std::move(families)}, line.can(), line.bit_rate());
    Scanned out{.predicted = diagnosis::expected_time(passes)};
    const TimePoint begin = clock.now();
    const auto done = scanner.sweep(passes, all, [] { return false; }, [](const Pass&, int) {}, out.found);
    EXPECT_TRUE(done) << to_sentence(done.error());
    out.took = clock.now() - begin;
    std::printf("predicted %.2f s, needed %.2f s, found %zu, left out %zu\n", seconds(out.predicted), seconds(out.took),
                out.found.size(), scanner.left_out());
    return out;
}

constexpr std::string_view nobody = R"(version = 1
name = "nobody"
[bus.only]
family = "nuri"
bit_rate = 9600
[joint.off]
bus = "only"
id = 3
[[sim.fault]]
kind = "unplug"
joint = "off"
)";

TEST(Scan, OfEveryBitRateAndIdOfNuriNeedsWhatWasPredictedAndLessThanEightMinutes)
{
    const auto scanned = scan(nobody, 9600, true, {find_family("nuri")});
    EXPECT_TRUE(scanned.found.empty());
    EXPECT_NEAR(seconds(scanned.took), seconds(scanned.predicted), 0.01 * seconds(scanned.predicted));
    EXPECT_LT(seconds(scanned.took), 8 * 60.0);
}

std::string one(std::string_view family, int id, std::uint32_t rate, std::string_view more = "")
{
    return fmt::format("version = 1\nname = \"one\"\n[bus.only]\nfamily = \"{}\"\nbit_rate = {}\n{}\n"
                       "[joint.j]\nbus = \"only\"\nid = {}\n{}",
                       family, rate, more, id, family == "sam" ? "model = \"SAM-20\"\n" : "");
}

TEST(Scan, FindsOneDeviceAsItWasDeliveredWithinThreeSeconds)
{
    for (const auto* family : families()) {
        const std::uint32_t opened = family->can ? family->default_bit_rate : 1'500'000;
        const auto scanned = scan(one(family->name, family->default_id, family->default_bit_rate), opened);
        ASSERT_EQ(scanned.found.size(), 1U) << family->name;
        EXPECT_EQ(scanned.found[0].family, family);
        EXPECT_EQ(scanned.found[0].id, family->default_id);
        EXPECT_LT(seconds(scanned.took), 3.0) << family->name;
    }
}

TEST(Scan, FindsADeviceAtAnUnlikelyIdAndBitRate)
{
    const auto scanned = scan(one("nuri", 200, 38400), 1'500'000);
    ASSERT_EQ(scanned.found.size(), 1U);
    EXPECT_EQ(scanned.found[0].id, 200);
    EXPECT_EQ(scanned.found[0].bit_rate, 38400U);
}

TEST(Scan, FindsEveryDeviceBehindAnAdapterWithALatencyOf16Ms)
{
    const auto scanned = scan(one("nuri", 1, 115200, "[bus.only.sim]\nusb_latency_s = 0.016\n") +
                                  "[joint.k]\nbus = \"only\"\nid = 254\n[joint.l]\nbus = \"only\"\nid = 20\n",
                              115200);
    ASSERT_EQ(scanned.found.size(), 3U);
    EXPECT_EQ(scanned.found[1].id, 20);
    EXPECT_EQ(scanned.found[2].id, 254);
}

TEST(Scan, FindsWhoAnswersAsLateAsTheManualAllows)
{
    const auto scanned = scan(R"(version = 1
name = "late"
[bus.only]
family = "nuri"
bit_rate = 115200
[joint.a]
bus = "only"
id = 1
[joint.b]
bus = "only"
id = 5
[joint.c]
bus = "only"
id = 60
profile_options = { response_time_us = 25400 }
[joint.d]
bus = "only"
id = 61
)",
                              115200, true, {find_family("nuri")});
    EXPECT_EQ(scanned.found.size(), 4U);
}

/// A CAN bus that another master reads all the time. A motor has room for one question: of two that come to it within
/// `busy` it answers the other master's, and we hear that answer, which is none to ours.
class SharedBus final : public link::CanLink, public link::Clock
{
public:
    static constexpr Duration period = std::chrono::milliseconds(20);
    static constexpr Duration busy = std::chrono::milliseconds(1);

    SharedBus(std::unique_ptr<link::CanLink> link, link::Clock& clock, Duration phase)
        : link_(std::move(link)), clock_(clock), next_(clock.now() + phase)
    {
    }

    TimePoint now() const override { return clock_.now(); }
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override
    {
        clock_.wait(handles, std::min(deadline, next_));
        if (clock_.now() < next_)
            return;
        for (int id = 1; id <= 4; ++id) {
            const auto asked = wire::make_request(id, rmd::ReadStatus2{});
            EXPECT_TRUE(asked && link_->write({&asked->frame, 1}));
        }
        asked_ = next_;
        next_ += period;
    }

    std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) override
    {
        const bool meets = std::min(now() - asked_, next_ - now()) < busy;
        for (const auto& frame : frames) {
            if (meets && frame.can_id <= 0x144)
                continue;
            if (const auto sent = link_->write({&frame, 1}); !sent)
                return sent;
        }
        return frames.size();
    }
    std::expected<link::Arrival, Error> read(std::span<wire::Frame> into) override { return link_->read(into); }
    int handle() const override { return link_->handle(); }
    link::LinkState state() const override { return link_->state(); }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return link_->set_bit_rate(rate); }

private:
    std::unique_ptr<link::CanLink> link_;
    link::Clock& clock_;
    TimePoint next_;
    TimePoint asked_ = next_ - period;
};

TEST(Scan, FindsEveryDeviceOfACanBusThatAnotherMasterReadsAt50Hz)
{
    std::string robot = one("rmd", 1, 1'000'000);
    for (int id = 2; id <= 4; ++id)
        robot += fmt::format("[joint.j{}]\nbus = \"only\"\nid = {}\n", id, id);
    const auto file = config::parse_robot_file(robot, "scan.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    for (Duration phase{}; phase < SharedBus::period; phase += std::chrono::microseconds(500)) {
        auto simulator = sim::Simulator::make(*file);
        ASSERT_TRUE(simulator);
        auto link = (*simulator)->open("");
        ASSERT_TRUE(link);
        auto shared = std::make_unique<SharedBus>(std::get<std::unique_ptr<link::CanLink>>(std::move(*link)),
                                                  (*simulator)->clock(), phase);
        link::Clock& clock = *shared;
        diagnosis::Line line(std::move(shared), clock);
        diagnosis::Scanner scanner(line);
        const auto passes = diagnosis::passes({}, true, line.bit_rate());
        std::vector<Found> found;
        const TimePoint begin = clock.now();
        const auto done = scanner.sweep(passes, false, [] { return false; }, [](const Pass&, int) {}, found);
        ASSERT_TRUE(done) << to_sentence(done.error());
        EXPECT_EQ(found.size(), 4U) << "phase " << seconds(phase);
        EXPECT_LE(clock.now() - begin, diagnosis::expected_time(passes));
    }
}

TEST(Scan, OfACanBusIsOverWithinTheTimeThatWasPredicted)
{
    for (const auto* more : {"", "[[sim.fault]]\nkind = \"unplug\"\njoint = \"j\"\n"}) {
        const auto scanned = scan(one("rmd", 1, 1'000'000) + more, 1'000'000);
        EXPECT_LE(scanned.took, scanned.predicted) << more;
    }
}

} // namespace
} // namespace sinew
