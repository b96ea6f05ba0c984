#include "sinew/link/echo.hpp"

#include "sinew/link/link_test_support.hpp"

namespace sinew::link {
namespace {

using test::ScriptedLink;

class Echo : public ::testing::Test
{
protected:
    Echo()
    {
        auto inner = std::make_unique<ScriptedLink>();
        inner_ = inner.get();
        link_ = std::make_unique<EchoLink>(std::move(inner));
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

    ScriptedLink* inner_ = nullptr;
    std::unique_ptr<EchoLink> link_;
};

TEST_F(Echo, IsSwallowedHoweverItIsSplit)
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

TEST_F(Echo, OfTwoRequestsInARowIsSwallowed)
{
    write("one");
    write("two");
    inner_->reads = {"onet", "wo", "answers"};
    EXPECT_EQ(read_all(), "answers");
}

TEST_F(Echo, ThatNeverComesCostsTheAnswerNothing)
{
    for (const std::size_t size : {1u, 3u, 64u}) {
        write("ABCDE");
        inner_->reads = {"ABC", "xyz"};
        EXPECT_EQ(read_all(size), "ABCxyz");
    }
}

TEST_F(Echo, ThatIsDamagedIsPassedOnWithAllThatFollows)
{
    write("request");
    inner_->reads = {"reqXestanswer"};
    EXPECT_EQ(read_all(), "reqXestanswer");
    write("again");
    inner_->reads = {"againanswer"};
    EXPECT_EQ(read_all(), "answer");
}

TEST_F(Echo, IsExpectedOnlyOfWhatTheAdapterTook)
{
    inner_->room = 3;
    EXPECT_EQ(link_->write(test::bytes("request")).value(), 3u);
    inner_->reads = {"reqanswer"};
    EXPECT_EQ(read_all(), "answer");
}

TEST_F(Echo, LeavesUnaskedBytesAlone)
{
    inner_->reads = {"hello"};
    EXPECT_EQ(read_all(2), "hello");
    EXPECT_EQ(inner_->written, "");
}

TEST_F(Echo, TakesNoMoreThanItCanRemember)
{
    const std::string much(2000, 'x');
    const std::size_t taken = link_->write(test::bytes(much)).value();
    EXPECT_LT(taken, much.size());
    EXPECT_EQ(link_->write(test::bytes(much)).value(), 0u);
    inner_->reads = {much.substr(0, taken), "answer"};
    EXPECT_EQ(read_all(), "answer");
    EXPECT_GT(link_->write(test::bytes("more")).value(), 0u);
}

TEST_F(Echo, PassesTheRestOfTheLinkThrough)
{
    EXPECT_EQ(link_->handle(), 77);
    EXPECT_EQ(link_->state().bit_rate, 9600u);
    EXPECT_EQ(link_->set_bit_rate(115200).value(), 115200u);
    inner_->reads = {"x"};
    std::array<std::uint8_t, 4> into;
    EXPECT_EQ(link_->read(into)->at, TimePoint{} + Duration{1});
}

} // namespace
} // namespace sinew::link
