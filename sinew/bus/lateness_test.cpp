#include "sinew/bus/lateness.hpp"

#include "sinew/bus/fake_unusual.hpp"

#include <gtest/gtest.h>

namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

const fake::FakeProtocol protocol{false};
constexpr TimePoint start{1s};
constexpr TimePoint own{1s};  // the own answer of what is asked about is never late here
constexpr TimePoint end{10s}; // something else is owed until then, so that every question is looked into

template <class M>
wire::Request ask(int id, const M& message)
{
    return *wire::make_request(id, message);
}

wire::Frame answer(int id, std::uint8_t value = 42)
{
    return {.size = 4, .data = {0x55, static_cast<std::uint8_t>(id), 1, value}};
}

TEST(Lateness, AnAnswerThatHasComeIsOwedNoMore)
{
    Lateness lateness;
    const auto read = ask(3, fake::Read{});
    lateness.owe(ask(9, fake::Read{}), end);
    lateness.owe(read, start + 50ms);
    ASSERT_NE(lateness.settle(protocol, answer(3), start + 10ms), nullptr);
    EXPECT_FALSE(lateness.may_be_older(read, start + 20ms, own));
    EXPECT_EQ(lateness.settle(protocol, answer(3), start + 20ms), nullptr) << "a second one is nobody's";
}

TEST(Lateness, WhatIsOwedAnewIsOwedForItsOwnTime)
{
    Lateness lateness;
    const auto read = ask(3, fake::Read{});
    lateness.owe(ask(9, fake::Read{}), end);
    lateness.owe(read, start + 50ms);
    ASSERT_NE(lateness.settle(protocol, answer(3), start), nullptr);
    lateness.owe(read, start + 20ms);
    EXPECT_TRUE(lateness.may_be_older(read, start + 20ms, own));
    EXPECT_FALSE(lateness.may_be_older(read, start + 30ms, own));
}

TEST(Lateness, OfTwoThatAreOwedOneIsLeftWhenOneHasCome)
{
    Lateness lateness;
    const auto read = ask(3, fake::Read{});
    lateness.owe(read, start + 50ms);
    lateness.owe(read, start + 60ms);
    ASSERT_NE(lateness.settle(protocol, answer(3), start + 10ms), nullptr);
    EXPECT_TRUE(lateness.may_be_older(read, start + 60ms, own));
    EXPECT_NE(lateness.settle(protocol, answer(3), start + 60ms), nullptr);
    EXPECT_FALSE(lateness.may_be_older(read, start + 60ms, own));
}

TEST(Lateness, AnAnswerIsOwedUpToTheLastInstantAndNotBeyond)
{
    Lateness lateness;
    const auto read = ask(3, fake::Read{});
    lateness.owe(ask(9, fake::Read{}), end);
    lateness.owe(read, start + 50ms);
    EXPECT_TRUE(lateness.may_be_older(read, start + 50ms, own));
    EXPECT_FALSE(lateness.may_be_older(read, start + 50ms + 1ns, own));
    EXPECT_EQ(lateness.settle(protocol, answer(3), start + 50ms + 1ns), nullptr);
    EXPECT_NE(lateness.settle(protocol, answer(3), start + 50ms), nullptr);
}

TEST(Lateness, WhatAnotherDeviceOrMessageOwesMakesNoAnswerDoubtful)
{
    Lateness lateness;
    lateness.owe(ask(3, fake::Read{}), end);
    EXPECT_FALSE(lateness.may_be_older(ask(4, fake::Read{}), start, own));
    EXPECT_FALSE(lateness.may_be_older(ask(3, fake::Set{}), start, own));
    EXPECT_TRUE(lateness.may_be_older(ask(3, fake::Read{}), start, own));
}

TEST(Lateness, AnAnswerThatLooksLikeThatOfAnotherMessageIsDoubtful)
{
    Lateness lateness;
    lateness.owe(ask(3, fake::Read{}), end);
    EXPECT_TRUE(lateness.may_be_older(ask(3, fake::ReadToo{}), start, own));
    EXPECT_FALSE(lateness.may_be_older(ask(4, fake::ReadToo{}), start, own));
    EXPECT_FALSE(lateness.may_be_older(ask(3, fake::ReadMore{}), start, own)) << "it is longer";
}

TEST(Lateness, WhatAllMotorsAnswerIsLikeWhatEachOfThemDoes)
{
    Lateness of_all;
    of_all.owe(ask(0, fake::ReadAll{}), end);
    EXPECT_TRUE(of_all.may_be_older(ask(4, fake::CanRead{}), start, own));
    Lateness of_one;
    of_one.owe(ask(4, fake::CanRead{}), end);
    EXPECT_TRUE(of_one.may_be_older(ask(0, fake::ReadAll{}), start, own));
    EXPECT_FALSE(of_one.may_be_older(ask(5, fake::CanRead{}), start, own));
}

TEST(Lateness, TheOwnAnswerOfADoubtfulOneIsOwedInItsPlace)
{
    Lateness lateness;
    const auto read = ask(3, fake::Read{});
    lateness.owe(read, start + 50ms);
    ASSERT_TRUE(lateness.may_be_older(read, start + 40ms, start + 90ms));
    EXPECT_TRUE(lateness.is_possible(start + 90ms));
    EXPECT_TRUE(lateness.may_be_older(read, start + 90ms, own));
    EXPECT_FALSE(lateness.is_possible(start + 90ms + 1ns));
}

TEST(Lateness, EveryAnswerOfADoubtfulLineMayBeOlder)
{
    Lateness lateness;
    lateness.doubt_all(start + 50ms);
    lateness.owe(ask(9, fake::Read{}), end);
    EXPECT_TRUE(lateness.may_be_older(ask(3, fake::Read{}), start + 50ms, end));
    EXPECT_FALSE(lateness.may_be_older(ask(4, fake::Read{}), start + 50ms + 1ns, own));
    EXPECT_TRUE(lateness.may_be_older(ask(3, fake::Read{}), start + 50ms + 1ns, own)) << "its own one is owed";
}

TEST(Lateness, WhereMoreIsOwedThanCanBeKeptAllIsDoubtfulUntilWhatWasDroppedIsOver)
{
    wire::Request asked = ask(0, fake::Read{});
    const auto may_be_older = [&](int owed, int id, TimePoint at) {
        Lateness lateness;
        for (asked.id = 0; asked.id < owed; ++asked.id)
            for (int again = 0; again <= asked.id % 2; ++again) // takes no room of its own
                lateness.owe(asked, end + asked.id * 1ms);
        asked.id = id;
        return lateness.may_be_older(asked, at, own);
    };
    EXPECT_FALSE(may_be_older(64, 100, start)) << "64 fit";
    EXPECT_TRUE(may_be_older(65, 100, end)) << "that of device 0, which is over first, had to go";
    EXPECT_FALSE(may_be_older(65, 100, end + 1ns));
    EXPECT_TRUE(may_be_older(65, 1, end + 1ms)) << "that of device 1 is still known";
}

TEST(Lateness, WhatIsOwedNoMoreMakesRoomBeforeWhatIsOverFirst)
{
    Lateness lateness;
    lateness.owe(ask(9, fake::Read{}), end);
    wire::Request asked = ask(0, fake::Read{});
    for (asked.id = 100; asked.id < 163; ++asked.id) // 64 with the one of device 9
        lateness.owe(asked, asked.id == 100 ? end + 1s : end);
    ASSERT_NE(lateness.settle(protocol, answer(0), start), nullptr) << "the first of them, which was over last";
    lateness.owe(asked, end);
    EXPECT_FALSE(lateness.may_be_older(ask(4, fake::Read{}), start, own)) << "there was room";
}

TEST(Lateness, WhereNothingIsOwedNoAnswerIsOlder)
{
    Lateness lateness;
    EXPECT_FALSE(lateness.may_be_older(ask(3, fake::Read{}), start, own));
}

} // namespace
} // namespace sinew::bus
