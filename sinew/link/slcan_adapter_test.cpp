#include "sinew/link/slcan_adapter.hpp"

#include "sinew/link/link_test_support.hpp"

#include <vector>

namespace sinew::link {
namespace {

class Adapter : public ::testing::Test
{
protected:
    /// What the adapter answers to the text; frames for the bus collect in `bus_`.
    std::string say(std::string_view text)
    {
        adapter_.take(test::bytes(text), [&](const wire::Frame& frame) {
            if (bus_takes_)
                bus_.push_back(frame);
            return bus_takes_;
        });
        return fetch();
    }
    std::string fetch()
    {
        const std::string answer(adapter_.pending().begin(), adapter_.pending().end());
        adapter_.drop(answer.size());
        return answer;
    }

    SlcanAdapter adapter_;
    std::vector<wire::Frame> bus_;
    bool bus_takes_ = true;
};

const wire::Frame frame{.can_id = 0x141, .size = 2, .data = {0xAA, 0xBB}};

TEST_F(Adapter, OpensAtTheRateOfItsCode)
{
    for (char code = '0'; code <= '8'; ++code) {
        EXPECT_EQ(say(std::string{"S"} + code + "\r"), "\r");
        EXPECT_EQ(adapter_.bit_rate(), slcan::bit_rates[static_cast<std::size_t>(code - '0')]);
    }
    EXPECT_FALSE(adapter_.is_open());
    EXPECT_EQ(say("O\r"), "\r");
    EXPECT_TRUE(adapter_.is_open());
    EXPECT_EQ(say("C\r"), "\r");
    EXPECT_FALSE(adapter_.is_open());
}

TEST_F(Adapter, RefusesCommandsAtTheWrongMoment)
{
    EXPECT_EQ(say("O\r"), "\a") << "no rate yet";
    EXPECT_EQ(say("C\r"), "\a") << "not open";
    EXPECT_EQ(say("t1412AABB\r"), "\a") << "not open";
    EXPECT_EQ(say("F\r"), "\a") << "not open";
    EXPECT_EQ(say("S8\rO\r"), "\r\r");
    EXPECT_EQ(say("S6\r"), "\a") << "open";
    EXPECT_EQ(say("s031C\r"), "\a") << "open";
    EXPECT_EQ(say("O\r"), "\a") << "open";
    EXPECT_EQ(say("Z0\rX1\rM00000000\r"), "\a\a\a") << "open";
    EXPECT_EQ(adapter_.bit_rate(), 1'000'000u);
    EXPECT_TRUE(bus_.empty());
}

TEST_F(Adapter, RefusesWhatIsNoCommand)
{
    EXPECT_EQ(say("S9\rS\rS88\rs12\rOO\rM1\rmGGGGGGGG\rZ1\rZ\rX2\rQ\rU2\r"), "\a\a\a\a\a\a\a\a\a\a\a\a");
    EXPECT_EQ(say(std::string(100, 'S') + "\r"), "\a");
    EXPECT_EQ(say("S8\a"), "\a");
    EXPECT_EQ(adapter_.bit_rate(), 0u);
}

TEST_F(Adapter, AnswersQuestionsInTheFormThatPythonCanReads)
{
    EXPECT_EQ(say("V\r"), "V1013\r");
    EXPECT_EQ(say("v\r"), "v1013\r");
    EXPECT_EQ(say("N\r"), "NSNEW\r");
    EXPECT_EQ(say("\r"), "\r");
    EXPECT_EQ(say("Z0\rX0\rX1\rM00000000\rmFFFFFFFF\r"), "\r\r\r\r\r");
    EXPECT_EQ(say("S8\rO\rF\r"), "\r\rF00\r");
}

TEST_F(Adapter, TakesRegistersAsARateThatItDoesNotKnow)
{
    EXPECT_EQ(say("s031C\rO\r"), "\r\r");
    EXPECT_TRUE(adapter_.is_open());
    EXPECT_EQ(adapter_.bit_rate(), 0u);
}

TEST_F(Adapter, PutsFramesOnTheBusOnlyWhileOpen)
{
    EXPECT_EQ(say("S8\rO\rt1412AABB\r"), "\r\rz\r");
    ASSERT_EQ(bus_.size(), 1u);
    EXPECT_EQ(bus_[0], frame);
    EXPECT_EQ(say("t1412AAB\rt9990\r"), "\a\a");
    EXPECT_EQ(say("T000001412AABB\rr1410\rR000001410\r"), "Z\rz\rZ\r");
    EXPECT_EQ(bus_.size(), 1u) << "no device here speaks extended or remote frames";
    EXPECT_EQ(say("C\rt1412AABB\r"), "\r\a");
    EXPECT_EQ(bus_.size(), 1u);
}

TEST_F(Adapter, OnlyListensWhenToldTo)
{
    EXPECT_EQ(say("S8\rL\r"), "\r\r");
    EXPECT_EQ(say("t1412AABB\r"), "\a");
    EXPECT_TRUE(bus_.empty());
    EXPECT_TRUE(adapter_.offer(frame));
    EXPECT_EQ(fetch(), "t1412AABB\r");
}

TEST_F(Adapter, ShowsTheBusToTheHostOnlyWhileOpen)
{
    EXPECT_FALSE(adapter_.offer(frame));
    say("S8\rO\r");
    EXPECT_TRUE(adapter_.offer(frame));
    EXPECT_EQ(fetch(), "t1412AABB\r");
    say("C\r");
    EXPECT_FALSE(adapter_.offer(frame));
    EXPECT_EQ(fetch(), "");
}

TEST_F(Adapter, DropsFramesThatTheHostDoesNotFetch)
{
    say("S8\rO\r");
    int taken = 0;
    while (adapter_.offer(frame))
        ++taken;
    EXPECT_EQ(fetch().size(), taken * std::string_view{"t1412AABB\r"}.size());
    EXPECT_TRUE(adapter_.offer(frame));
}

TEST_F(Adapter, TellsByFThatFramesWereLostAndForgetsIt)
{
    say("S8\rO\r");
    while (adapter_.offer(frame))
        ;
    fetch();
    EXPECT_EQ(say("F\r"), "F01\r");
    EXPECT_EQ(say("F\r"), "F00\r");
    adapter_.note(slcan::flag::bus_error | slcan::flag::error_passive);
    EXPECT_EQ(say("F\rF\r"), "FA0\rF00\r");
}

TEST_F(Adapter, RefusesAFrameThatTheBusDoesNotTake)
{
    say("S8\rO\r");
    bus_takes_ = false;
    EXPECT_EQ(say("t1412AABB\r"), "\a");
    bus_takes_ = true;
    EXPECT_EQ(say("t1412AABB\rF\r"), "z\rF02\r");
    EXPECT_EQ(bus_.size(), 1u);
}

TEST_F(Adapter, FollowsTheConversationOfPythonCan)
{
    // slcanBus(bitrate=1000000): set_bitrate is close, rate, open; then the constructor opens once more
    EXPECT_EQ(say("C\r"), "\a");
    EXPECT_EQ(say("S8\r"), "\r");
    EXPECT_EQ(say("O\r"), "\r");
    EXPECT_EQ(say("O\r"), "\a");
    EXPECT_EQ(say("t1412AABB\r"), "z\r");
    ASSERT_EQ(bus_.size(), 1u);
    EXPECT_TRUE(adapter_.offer(frame));
    EXPECT_EQ(fetch(), "t1412AABB\r");
    EXPECT_EQ(say("C\r"), "\r");
}

TEST_F(Adapter, HearsTheSameHoweverTheHostSplitsItsBytes)
{
    const std::string conversation = "C\rS8\rO\rt1412AABB\rT000001410\rbad\rt7FF0\rC\r";
    const std::string answers = say(conversation);
    const auto frames = bus_;
    ASSERT_EQ(frames.size(), 2u);
    for (std::size_t split = 0; split <= conversation.size(); ++split) {
        adapter_.reset();
        bus_.clear();
        std::string heard = say(conversation.substr(0, split));
        heard += say(conversation.substr(split));
        EXPECT_EQ(heard, answers) << split;
        EXPECT_EQ(bus_, frames) << split;
    }
}

} // namespace
} // namespace sinew::link
