#include "sinew/diagnosis/doctor.hpp"
#include "sinew/link/slcan.hpp"
#include "sinew/link/slcan_adapter.hpp"

#include <algorithm>
#include <deque>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

/// What is looked at before anybody is asked: the port. The devices are in tests/scenario.
namespace sinew::diagnosis {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// A line on which nobody is.
class Silence final : public link::ByteLink
{
public:
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        if (is_lost)
            return fail(Errc::link_lost, "the adapter is gone");
        return bytes.size();
    }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t>) override { return link::Arrival{}; }
    int handle() const override { return -1; }
    link::LinkState state() const override { return {.open = !is_lost, .bit_rate = 9600}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return rate; }

    bool is_lost = false;
};

/// Time passes when somebody waits.
class Hands final : public link::Clock
{
public:
    TimePoint now() const override { return now_; }
    void wait(std::span<const link::Handle>, TimePoint deadline) override { now_ = std::max(now_, deadline); }

private:
    TimePoint now_{};
};

class Port : public testing::Test
{
protected:
    Port() : root_(fs::temp_directory_path() / ("sinew-doctor-" + std::to_string(::getpid())))
    {
        fs::create_directories(root_ / "sys/class/tty/ttyUSB0/device");
        std::ofstream(device()) << "";
    }
    ~Port() override { fs::remove_all(root_); }

    std::string device() const { return (root_ / "ttyUSB0").string(); }
    void set_timer(int ms) { std::ofstream(root_ / "sys/class/tty/ttyUSB0/device/latency_timer") << ms << '\n'; }

    Examination look(const std::string& link = {}, std::optional<Error> refused = {}, bool is_lost = false)
    {
        const Surroundings around{
            .open = [&](const std::string&) -> std::expected<Opened, Error> {
                if (refused)
                    return std::unexpected(*refused);
                auto line = std::make_unique<Silence>();
                line->is_lost = is_lost;
                return Opened{std::unique_ptr<link::ByteLink>(std::move(line)), &clock_};
            },
            .roots = {.dev = root_.string(), .sys = (root_ / "sys").string(), .proc = (root_ / "proc").string()}};
        const auto spec = make_spec(*find_family("nuri"), "", "", 3);
        const Subject subject{.link = link.empty() ? "serial:" + device() + "?baud=9600" : link,
                              .family = find_family("nuri"),
                              .expected = {{3, "waist", *spec}}};
        return examine(subject, around);
    }

    static const Finding* find(const Examination& all, std::string_view name)
    {
        const auto found = std::ranges::find(all.findings, name, &Finding::name);
        return found == all.findings.end() ? nullptr : &*found;
    }

private:
    fs::path root_;
    Hands clock_;
};

TEST_F(Port, WithALatencyTimerOf16MsIsSlow)
{
    set_timer(16);
    const auto all = look();
    const auto* slow = find(all, "slow-adapter");
    ASSERT_NE(slow, nullptr);
    EXPECT_NE(slow->evidence.find("16 ms"), std::string::npos);
    EXPECT_NE(slow->next.find("ttyUSB0/latency_timer"), std::string::npos);
}

TEST_F(Port, WithALatencyTimerOf1MsIsFine)
{
    set_timer(1);
    const auto all = look();
    EXPECT_EQ(find(all, "slow-adapter"), nullptr);
    EXPECT_NE(find(all, "adapter"), nullptr);
}

TEST_F(Port, WhoseDriverDoesNotSwitchTheDirectionOfRs485IsNoted)
{
    EXPECT_NE(find(look("rs485:" + device() + "?baud=9600"), "direction-not-switched"), nullptr);
    EXPECT_EQ(find(look(), "direction-not-switched"), nullptr) << "nobody asked for it";
}

TEST_F(Port, SaysTheRateThatWasReallySetBesideTheOneThatWasAskedFor)
{
    const auto differs = look("serial:" + device() + "?baud=9700");
    EXPECT_EQ(find(differs, "port")->evidence, "open at 9600 bps, where 9700 were asked for, and nobody else has it");
    EXPECT_EQ(find(look(), "port")->evidence, "open at 9600 bps, and nobody else has it");
}

TEST_F(Port, OfABoxThatIsOutOfReachIsNotLookedForAmongTheDeviceFiles)
{
    Error refused{.code = Errc::link_not_found};
    refused.detail = "192.168.0.7:4001 refuses the connection";
    const auto all = look("tcp://192.168.0.7:4001", refused);
    ASSERT_EQ(all.findings.size(), 1U);
    EXPECT_EQ(all.findings[0].name, "box-unreachable");
    EXPECT_EQ(all.findings[0].evidence, refused.detail);
    EXPECT_EQ(all.findings[0].next.find("/dev"), std::string::npos);
}

TEST_F(Port, ThatIsNotThereIsNamedAndLeavesTheWireAlone)
{
    const auto all = look("serial:/dev/sinew-is-not-here?baud=9600");
    EXPECT_NE(find(all, "device-missing"), nullptr);
    EXPECT_EQ(all.findings.size(), 1U);
    EXPECT_NE(std::ranges::find(all.left_out, "bit-rate"), all.left_out.end());
}

TEST_F(Port, ThatIsRefusedIsNamedByTheReasonAndTheAdapterIsLookedAtAllTheSame)
{
    set_timer(16);
    for (const auto& [code, name] :
         {std::pair{Errc::link_busy, "port-busy"}, std::pair{Errc::link_failed, "link-failed"},
          std::pair{Errc::link_denied, "no-permission"}}) {
        Error error{.code = code};
        error.detail = "refused";
        const auto all = look({}, error);
        EXPECT_NE(find(all, name), nullptr) << name;
        EXPECT_NE(find(all, "slow-adapter"), nullptr) << name;
    }
}

TEST_F(Port, ThatIsLostWhileItIsLookedAtEndsTheWalk)
{
    const auto all = look({}, {}, true);
    EXPECT_NE(find(all, "link-lost"), nullptr);
    EXPECT_EQ(worst(all.findings), Severity::error);
}

TEST_F(Port, WithNobodyBehindItSaysSoAndHasAskedAtEveryBitRate)
{
    const auto all = look();
    const auto* none = find(all, "no-answer");
    ASSERT_NE(none, nullptr);
    EXPECT_NE(none->evidence.find("id 3 (waist)"), std::string::npos);
}

/// An SLCAN adapter on whose bus nobody is; a dead one says nothing at all, a late one refuses every frame, and
/// whatever it says takes so long.
class AloneOnItsBus final : public link::ByteLink
{
public:
    AloneOnItsBus(bool dead, std::uint8_t flags, Duration late, const link::Clock& clock)
        : is_dead_(dead), late_(late), clock_(clock)
    {
        adapter_.note(flags);
    }
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        if (!is_dead_)
            adapter_.take(bytes, [&](const wire::Frame&) { return late_ == Duration{}; });
        while (!adapter_.pending().empty()) {
            said_.emplace_back(clock_.now() + late_, adapter_.pending().front());
            adapter_.drop(1);
        }
        return bytes.size();
    }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t> into) override
    {
        std::size_t count = 0;
        for (; count < into.size() && !said_.empty() && said_.front().first <= clock_.now(); said_.pop_front())
            into[count++] = said_.front().second;
        return link::Arrival{.count = count};
    }
    int handle() const override { return -1; }
    link::LinkState state() const override { return {.open = true}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return rate; }

private:
    link::SlcanAdapter adapter_;
    bool is_dead_;
    Duration late_;
    const link::Clock& clock_;
    std::deque<std::pair<TimePoint, std::uint8_t>> said_;
};

class SlcanPort : public Port
{
protected:
    /// "adapter-silent warning", of those that are not in order, and "counters ok".
    std::vector<std::string> look_at_adapter(bool dead, std::uint8_t flags = 0, Duration late = {})
    {
        Hands clock;
        const Surroundings around{.open = [&](const std::string&) -> std::expected<Opened, Error> {
            auto opened =
                link::SlcanLink::open(std::make_unique<AloneOnItsBus>(dead, flags, late, clock), 1'000'000, clock);
            if (!opened)
                return std::unexpected(opened.error());
            return Opened{std::move(*opened), &clock};
        }};
        std::vector<std::string> out;
        for (const auto& finding :
             examine({.link = "slcan:" + device(), .family = find_family("rmd")}, around).findings)
            if (finding.severity != Severity::ok || finding.name == "counters")
                out.push_back(fmt::format("{} {}", finding.name, to_word(finding.severity)));
        return out;
    }
};

TEST_F(SlcanPort, WithAnAdapterThatAcknowledgesNothingSaysSo)
{
    using Names = std::vector<std::string>;
    EXPECT_EQ(look_at_adapter(true), (Names{"adapter-silent warning", "no-answer error", "counters ok"}));
    EXPECT_EQ(look_at_adapter(false), (Names{"no-answer error", "counters ok"}));
}

TEST_F(SlcanPort, TellsTheErrorsThatTheAdapterKept)
{
    namespace flag = link::slcan::flag;
    using Names = std::vector<std::string>;
    EXPECT_EQ(look_at_adapter(false, flag::bus_error), (Names{"no-answer error", "bus-errors warning"}));
    EXPECT_EQ(look_at_adapter(false, flag::error_passive), (Names{"no-answer error", "bus-errors error"}));
    EXPECT_EQ(look_at_adapter(false, flag::overrun | flag::bus_error),
              (Names{"no-answer error", "bus-errors warning", "frames-lost warning"}));
    EXPECT_EQ(look_at_adapter(false, flag::arbitration_lost), (Names{"no-answer error", "counters ok"}));
}

/// The answer to a question that a refusal asked is due still, and refusals of frames are on their way.
TEST_F(SlcanPort, WithAnAdapterThatAnswersLateTellsTheFramesThatItLostAllTheSame)
{
    namespace flag = link::slcan::flag;
    for (const Duration late : {10ms, 100ms, 200ms, 430ms, 460ms}) // the walk takes 0.9 s; the first answer, twice this
        EXPECT_EQ(
            std::ranges::count(look_at_adapter(false, flag::overrun | flag::bus_error, late), "frames-lost warning"), 1)
            << late.count();
}

TEST(CanInterface, IsNamedByWhatIsWrongWithIt)
{
    const auto names_of = [](std::expected<link::CanInterface, Error> interface) {
        const Surroundings around{.open = [](const std::string&) -> std::expected<Opened, Error> {
                                      return fail(Errc::link_busy, "not in this test");
                                  },
                                  .can_interface = [&](std::string_view) { return interface; }};
        std::vector<std::string> out;
        for (const auto& finding : examine({.link = "can:can0", .family = find_family("rmd")}, around).findings)
            if (finding.name != "port-busy")
                out.push_back(fmt::format("{} {}", finding.name, to_word(finding.severity)));
        return out;
    };
    using Names = std::vector<std::string>;
    using enum link::CanState;
    const link::CanInterface good{.name = "can0", .is_up = true, .bit_rate = 1'000'000, .state = error_active};
    auto down = good, warning = good, silent = good;
    down.is_up = false;
    warning.state = error_warning;
    silent.state = bus_off;
    EXPECT_EQ(names_of(good), (Names{"device-file ok", "adapter ok"}));
    EXPECT_EQ(names_of(down), (Names{"interface-down error"}));
    EXPECT_EQ(names_of(warning), (Names{"device-file ok", "can-errors warning"}));
    EXPECT_EQ(names_of(silent), (Names{"device-file ok", "can-errors error"}));
    EXPECT_EQ(names_of(fail(Errc::link_not_found, "no can0")), (Names{"device-missing error"}));
}

TEST(Findings, AreAsBadAsTheWorst)
{
    EXPECT_EQ(worst({}), Severity::ok);
    const Finding all[] = {
        {.severity = Severity::note}, {.severity = Severity::error}, {.severity = Severity::warning}};
    EXPECT_EQ(worst(all), Severity::error);
}

} // namespace
} // namespace sinew::diagnosis
