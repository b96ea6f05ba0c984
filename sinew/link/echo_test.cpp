#include "sinew/link/echo.hpp"

#include "sinew/link/link_test_support.hpp"

#include <fmt/format.h>
#include <random>

namespace sinew::link {
namespace {

using namespace std::chrono_literals;
using test::ScriptedLink;

class EchoTest : public ::testing::Test
{
protected:
    explicit EchoTest(Echo echo = Echo::on)
    {
        auto inner = std::make_unique<ScriptedLink>();
        inner_ = inner.get();
        link_ = std::make_unique<EchoLink>(std::move(inner), echo, clock_);
    }

    void write(std::string_view text) { ASSERT_EQ(link_->write(test::bytes(text)).value(), text.size()); }

    /// All that the link gives for the reads of the script, with buffers of that size.
    std::string read_all(std::size_t size = 64)
    {
        std::string text;
        for (int empty = 0; empty < 2;) {
            std::array<std::uint8_t, 64> into;
            const auto arrival = link_->read(std::span(into).first(size));
            EXPECT_TRUE(arrival);
            text.append(into.begin(), into.begin() + arrival->count);
            empty = arrival->count == 0 && inner_->reads.empty() ? empty + 1 : 0;
        }
        return text;
    }

    std::string exchange(std::string_view request, std::string heard)
    {
        write(request);
        if (!heard.empty())
            inner_->reads = {std::move(heard)};
        return read_all();
    }
    void time_out() { clock_.time += 1s; }

    test::HurryingClock clock_;
    ScriptedLink* inner_ = nullptr;
    std::unique_ptr<EchoLink> link_;
};

class AutomaticEcho : public EchoTest
{
protected:
    AutomaticEcho() : EchoTest(Echo::automatic) {}
};

TEST_F(EchoTest, IsSwallowedHoweverItIsSplit)
{
    const std::string heard = "requestanswer";
    for (std::size_t split = 1; split < heard.size(); ++split) {
        for (const std::size_t size : {1u, 3u, 64u}) {
            write("request");
            inner_->reads = {heard.substr(0, split), heard.substr(split)};
            EXPECT_EQ(read_all(size), "answer") << "split at " << split << ", read by " << size;
        }
    }
}

TEST_F(EchoTest, OfTwoRequestsInARowIsSwallowed)
{
    write("one");
    write("two");
    inner_->reads = {"onet", "wo", "answers"};
    EXPECT_EQ(read_all(), "answers");
}

TEST_F(EchoTest, ThatIsDamagedLetsNothingPassUntilTheNextWrite)
{
    for (const auto* heard : {"reqXestanswer", "equestanswer", "reqestanswer", "rrequesanswer", "XXXXXXXanswer"})
        EXPECT_EQ(exchange("request", heard), "") << heard;
    EXPECT_EQ(exchange("again", "againanswer"), "answer");
}

TEST_F(EchoTest, IsFoundBehindWhatCameTooLateForTheRequestBefore)
{
    EXPECT_EQ(exchange("request", "lateansrequestanswer"), "answer");
    EXPECT_EQ(exchange("request", "rererequestanswer"), "answer");
}

TEST_F(EchoTest, ThatNeverCameIsNotWaitedForAfterTheNextWrite)
{
    EXPECT_EQ(exchange("request", ""), "");
    time_out();
    EXPECT_EQ(exchange("request", "requestanswer"), "answer");
}

TEST_F(EchoTest, IsExpectedOnlyOfWhatTheAdapterTook)
{
    inner_->room = 3;
    EXPECT_EQ(link_->write(test::bytes("request")).value(), 3u);
    inner_->reads = {"reqanswer"};
    EXPECT_EQ(read_all(), "answer");
}

TEST_F(EchoTest, LeavesUnaskedBytesAlone)
{
    inner_->reads = {"hello"};
    EXPECT_EQ(read_all(2), "hello");
    EXPECT_EQ(inner_->written, "");
}

TEST_F(EchoTest, TakesNoMoreThanItCanRemember)
{
    const std::string much(2000, 'x');
    const std::size_t taken = link_->write(test::bytes(much)).value();
    EXPECT_LT(taken, much.size());
    EXPECT_EQ(link_->write(test::bytes(much)).value(), 0u);
    inner_->reads = {much.substr(0, taken), "answer"};
    EXPECT_EQ(read_all(), "answer");
    EXPECT_GT(link_->write(test::bytes("more")).value(), 0u);
}

TEST_F(EchoTest, PassesTheRestOfTheLinkThrough)
{
    EXPECT_EQ(link_->handle(), 77);
    EXPECT_EQ(link_->state().bit_rate, 9600u);
    EXPECT_EQ(link_->set_bit_rate(115200).value(), 115200u);
    inner_->reads = {"x"};
    std::array<std::uint8_t, 4> into;
    EXPECT_EQ(link_->read(into)->at, TimePoint{} + Duration{1});
}

TEST_F(AutomaticEcho, IsFoundByTheFirstWholeEchoHoweverItIsSplit)
{
    for (std::size_t split = 1; split < 13; ++split) {
        auto inner = std::make_unique<ScriptedLink>();
        inner_ = inner.get();
        link_ = std::make_unique<EchoLink>(std::move(inner), Echo::automatic, clock_);
        write("request");
        inner_->reads = {std::string("requestanswer").substr(0, split), std::string("requestanswer").substr(split)};
        EXPECT_EQ(read_all(), "answer");
        EXPECT_EQ(link_->echo(), Echo::on);
    }
}

TEST_F(AutomaticEcho, LetsTheFirstAnswerPassWhereThereIsNone)
{
    EXPECT_EQ(exchange("request", "an"), "an") << "two bytes are enough";
    EXPECT_EQ(exchange("request", "reanswer"), "reanswer");
    EXPECT_EQ(link_->echo(), Echo::automatic);
    EXPECT_EQ(exchange("request", "other"), "other");
    EXPECT_EQ(link_->echo(), Echo::off);
    EXPECT_EQ(exchange("request", "re"), "re") << "and now nothing is held back";
}

TEST_F(AutomaticEcho, TakesNoPieceOfADamagedEchoForAnAnswer)
{
    for (const auto* heard : {"reqXestanswer", "equestanswer", "reqestanswer", "rrequestanswer", "Xequestanswer"}) {
        EXPECT_EQ(exchange("request", heard), "") << heard;
        EXPECT_EQ(link_->echo(), Echo::automatic) << heard;
        time_out();
    }
    EXPECT_EQ(exchange("again", "againanswer"), "answer");
    EXPECT_EQ(link_->echo(), Echo::on);
}

TEST_F(AutomaticEcho, ReadsOnHoweverMuchFollowsADamagedEcho)
{
    write("request");
    inner_->reads = {"reqXest", std::string(2000, 'x')};
    std::array<std::uint8_t, 64> into;
    for (int i = 0; i < 40; ++i)
        EXPECT_EQ(link_->read(into)->count, 0U);
    EXPECT_TRUE(inner_->reads.empty());
}

TEST_F(AutomaticEcho, IsNotFoundAfterThreeAnswersThatLookLikeTheirRequests)
{
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(exchange("request", "re"), "");
        time_out();
    }
    EXPECT_EQ(exchange("request", "re"), "re");
    EXPECT_EQ(link_->echo(), Echo::off);
}

TEST_F(AutomaticEcho, StaysOpenWhileTheLineIsSilent)
{
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(exchange("request", ""), "");
        time_out();
    }
    EXPECT_EQ(exchange("request", "requestanswer"), "answer");
}

/// One exchange after the other with what an adapter may do to it; the seed tells it again.
struct Line {
    std::mt19937_64 random;
    bool echoes = true;

    std::size_t below(std::size_t count) { return random() % count; }
    std::string some(std::size_t least, std::size_t most)
    {
        std::string text(least + below(most - least + 1), '\0');
        for (char& c : text)
            c = static_cast<char>(below(4)); // few values, so that pieces look alike often
        return text;
    }
    std::string damage(std::string echo)
    {
        const std::size_t at = below(echo.size());
        switch (below(3)) {
        case 0:
            echo[at] = static_cast<char>(echo[at] ^ 0x10);
            break;
        case 1:
            echo.insert(at, 1, static_cast<char>(0x20));
            break;
        default:
            echo.erase(at, 1);
        }
        return echo;
    }
};

/// Requests of 4 to 12 bytes, answers that carry marked bytes an echo never has, so that a piece of an echo that passed
/// shows. Every split of the line and every size of the reader's buffer comes up.
void converse(Echo echo, std::uint64_t seed)
{
    SCOPED_TRACE(fmt::format("seed {}, echo {}", seed, echo == Echo::on ? "on" : "auto"));
    Line line{.random = std::mt19937_64{seed}, .echoes = echo == Echo::on || seed % 2 == 0};
    test::HurryingClock clock;
    auto made = std::make_unique<ScriptedLink>();
    ScriptedLink& inner = *made;
    inner.room = 1'000'000;
    EchoLink link{std::move(made), echo, clock};
    int without_echo = 0;
    for (int i = 0; i < 40; ++i) {
        const std::string request = line.some(4, 12);
        std::string answer = line.some(2, 9);
        for (char& c : answer)
            c = static_cast<char>(c | 0x40);
        ASSERT_EQ(link.write(test::bytes(request)).value(), request.size());
        const bool harmed = line.echoes && line.below(4) == 0;
        std::string heard = (line.echoes ? (harmed ? line.damage(request) : request) : "") + answer;
        while (!heard.empty()) {
            const std::size_t piece = 1 + line.below(heard.size());
            inner.reads.push_back(heard.substr(0, piece));
            heard.erase(0, piece);
        }
        std::string passed;
        for (int empty = 0; empty < 2;) {
            std::array<std::uint8_t, 64> into;
            const auto arrival = link.read(std::span(into).first(1 + line.below(into.size())));
            ASSERT_TRUE(arrival);
            passed.append(into.begin(), into.begin() + arrival->count);
            empty = arrival->count == 0 && inner.reads.empty() ? empty + 1 : 0;
        }
        // A damaged echo may hide its answer; nothing else may be lost, and never may a piece of the echo pass.
        if (!harmed || !passed.empty()) {
            ASSERT_EQ(passed, answer) << "exchange " << i << (harmed ? ", harmed" : "");
        }
        without_echo += line.echoes ? 0 : 1;
        if (without_echo == EchoLink::writes_to_decide) {
            ASSERT_EQ(link.echo(), Echo::off);
        }
        clock.time += 1s;
    }
    if (line.echoes) {
        EXPECT_EQ(link.echo(), Echo::on);
    }
}

TEST(EchoProperty, NeverPassesAPieceOfAnEchoNorLosesAnAnswerBehindAWholeOne)
{
    const std::uint64_t first = std::random_device{}();
    for (std::uint64_t seed = first; seed < first + 2000 && !::testing::Test::HasFatalFailure(); ++seed) {
        converse(Echo::on, seed);
        converse(Echo::automatic, seed);
    }
}

} // namespace
} // namespace sinew::link
