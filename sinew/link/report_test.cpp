#include "sinew/link/report.hpp"

#include "sinew/link/link_test_support.hpp"
#include "sinew/link/pty.hpp"
#include "sinew/link/serial.hpp"
#include "sinew/link/slcan.hpp"

#include <fmt/format.h>
#include <map>

namespace sinew::link {
namespace {

std::vector<std::string> names(const std::vector<Setting>& settings)
{
    std::vector<std::string> out;
    for (const auto& setting : settings)
        out.emplace_back(setting.name);
    return out;
}

TEST(ReportOfAPort, SaysWhatTheDriverGaveAndWhatItRefused)
{
    const Adapter ftdi{.driver = "ftdi_sio", .latency_timer_ms = 1};
    EXPECT_EQ(to_words(settings_of(ftdi, {.low_latency = true, .rs485 = true}, true)),
              "driver ftdi_sio, low latency, latency timer 1 ms, the driver switches the direction");
    EXPECT_EQ(to_words(settings_of({.driver = "cp210x"}, {.low_latency = false, .rs485 = false}, true)),
              "driver cp210x, low latency refused by the driver, the driver does not switch the direction, so the "
              "adapter has to");
    EXPECT_EQ(to_words(settings_of({.driver = "cdc_acm"}, {}, true)),
              "driver cdc_acm, the driver does not switch the direction, so the adapter has to")
        << "a driver that does not know the question does not switch";
    EXPECT_EQ(names(settings_of({}, {.rs485 = true}, false)), std::vector<std::string>{}) << "nobody asked for it";
}

TEST(ReportOfAPort, AsksTheOneThatIsOpen)
{
    RealClock clock;
    const auto master = PtyMaster::open(9600, clock);
    ASSERT_TRUE(master);
    const auto uri = *parse_uri(fmt::format("rs485:{}?baud=9600", (*master)->device()));
    auto port = open_serial(uri, clock);
    ASSERT_TRUE(port) << to_sentence(port.error());
    const AnyLink link{std::move(*port)};
    const auto report = report_of(uri, link);
    EXPECT_EQ(names(report.settings), std::vector<std::string>{"rs485"}) << "a pseudo terminal has no driver";
    EXPECT_TRUE(report.tallies.empty());
}

TEST(ReportOfAnSlcanAdapter, CountsWhatItDidSinceItWasOpened)
{
    test::HurryingClock clock;
    auto owned = std::make_unique<test::ScriptedLink>();
    auto& adapter = *owned;
    const AnyLink link{*SlcanLink::open(std::move(owned), 1'000'000, clock)};
    const auto uri = *parse_uri("slcan:/dev/sinew-is-not-here");
    const auto says = [&] { return to_words(report_of(uri, link).settings); };
    EXPECT_EQ(says(), "the SLCAN adapter has never answered");

    auto& can = *std::get<std::unique_ptr<CanLink>>(link);
    const auto hear = [&](std::string text) {
        adapter.reads.push_back(std::move(text));
        std::array<wire::Frame, 4> into;
        ASSERT_TRUE(can.read(into));
    };
    hear("t1410\rT1FFFFFFF0\rt14\r\a");
    hear("FA1\r");
    EXPECT_EQ(says(), "the SLCAN adapter answers, it reports bus error, error passive, receive queue full");
    std::map<std::string_view, std::uint64_t> counts;
    for (const auto& tally : report_of(uri, link).tallies)
        counts[tally.name] = tally.count;
    EXPECT_EQ(counts, (std::map<std::string_view, std::uint64_t>{
                          {"refused", 1}, {"malformed", 1}, {"foreign", 1}, {"overruns", 1}}));
}

TEST(ReportOfACanInterface, HasWhatTheKernelTells)
{
    const CanInterface one{
        .kind = "can", .tx_queue = 10, .restart_ms = 100, .state = CanState::error_passive, .tx_errors = 128};
    EXPECT_EQ(to_words(settings_of(one)), "kind can, error-passive, txqueuelen 10, restarts after 100 ms, 128 errors "
                                          "sending, 0 errors receiving");
}

} // namespace
} // namespace sinew::link
