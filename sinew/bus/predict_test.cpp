#include "sinew/bus/predict.hpp"

#include "sinew/bus/fake_unusual.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

constexpr Line serial{.can = false, .bit_rate = 100'000}; // a byte takes 100 µs
constexpr Line can{.can = true, .bit_rate = 1'000'000};

template <class M>
wire::Request ask(int id, const M& message, Duration response = {})
{
    return *wire::make_request(id, message, {}, response);
}

TEST(Predict, AByteHasTenBitsAndACanFrameAsManyAsItsStuffingMakes)
{
    EXPECT_EQ(frame_bits(false, 7), 70);
    // ISO 11898-1: 108 bits with eight data bytes, up to 24 stuff bits, 3 between frames.
    EXPECT_EQ(frame_bits(true, 8, Stuffing::least), 111);
    EXPECT_EQ(frame_bits(true, 8), 135);
    EXPECT_EQ(frame_bits(true, 0, Stuffing::least), 47);
}

TEST(Predict, AnExchangeIsItsBitsBothWaysAndTheResponse)
{
    const Exchange one = predict(serial, ask(3, fake::BareRead{}, 2ms));
    EXPECT_EQ(one.request, 400us);
    EXPECT_EQ(one.response, 2ms);
    EXPECT_EQ(one.replies, 200us);
    EXPECT_EQ(one.total(), 2600us);
    EXPECT_EQ(one.wire(), 600us);
    auto unanswered = ask(3, fake::BareRead{}, 2ms);
    unanswered.answered = false;
    EXPECT_EQ(predict(serial, unanswered).total(), 400us);
}

TEST(Predict, ATimetableKnowsFramesOfEverySize)
{
    auto request = ask(3, fake::Read{}, 2ms);
    for (const Line& line : {serial, can}) {
        const Timetable times(line);
        for (std::size_t bytes = 0; bytes <= wire::Frame::capacity; ++bytes) {
            request.frame.size = static_cast<std::uint8_t>(bytes);
            EXPECT_EQ(times.predict(request).request, frame_time(line, bytes)) << bytes;
            EXPECT_EQ(times.predict_single(request).total(), predict(line, request).total()) << bytes;
        }
    }
}

TEST(Predict, ALineWhoseRateNobodyKnowsTakesNoTime)
{
    EXPECT_EQ(predict({}, ask(3, fake::Read{})).total(), 0us);
    const std::vector on_can{ask(1, fake::CanRead{}, 1ms), ask(2, fake::CanRead{}, 3ms)};
    EXPECT_EQ(predict_cycle({.can = true}, on_can), 3ms) << "only the devices do";
    EXPECT_EQ(predict_cycle({}, on_can), 4ms) << "one after the other";
}

TEST(Predict, ACycleOnASerialLineIsTheSumOfItsExchanges)
{
    const std::vector requests{ask(1, fake::Read{}, 1ms), ask(2, fake::Read{}, 3ms)};
    EXPECT_EQ(predict_cycle(serial, requests), 2 * 800us + 4ms);
}

TEST(Predict, ACycleOnCanWaitsForResponsesOnlyWhereTheWireIsIdle)
{
    const Duration frame = frame_time(can, 2);
    const Duration space = 3us;
    EXPECT_EQ(predict_cycle(can, std::vector{ask(1, fake::CanRead{}, 1ms)}), 2 * frame + 1ms - space);
    // The shorter response passes while the longer one is waited for.
    const std::vector apart{ask(1, fake::CanRead{}, 1ms), ask(2, fake::CanRead{}, 3ms)};
    EXPECT_EQ(predict_cycle(can, apart), 3 * frame + 3ms - space);
    // One identifier: one after the other.
    const std::vector shared{ask(1, fake::CanRead{}, 1ms), ask(1, fake::CanRead{}, 3ms)};
    EXPECT_EQ(predict_cycle(can, shared), 4 * frame + 4ms - 2 * space);
    EXPECT_LT(predict_cycle(can, apart, Stuffing::least), predict_cycle(can, apart));
}

TEST(Predict, AReplyWinsTheBusOnlyWhereItsIdentifierIsLower)
{
    // The first reply and the second request are ready at once; what the second device takes passes meanwhile or not.
    std::vector requests{ask(1, fake::CanRead{}), ask(2, fake::CanRead{}, 1ms)};
    const Duration rest = 3 * frame_time(can, 2) + 1ms - 3us;
    EXPECT_EQ(predict_cycle(can, requests), rest + frame_time(can, 2)) << "0x101 goes before 0x102";
    for (auto& request : requests)
        request.options.can_reply_base = 0x300;
    EXPECT_EQ(predict_cycle(can, requests), rest) << "0x102 goes before 0x301";
    EXPECT_EQ(predict_cycle(can, std::vector{ask(2, fake::CanRead{}), ask(1, fake::CanRead{}, 1ms)}), rest)
        << "0x101 goes before 0x102";
}

TEST(Predict, ACycleOfFramesThatWereSeenCountsTheirBits)
{
    const std::vector requests{ask(1, fake::CanRead{}, 1ms), ask(2, fake::CanRead{}, 3ms)};
    const std::vector<ExchangeBits> bits{{60, 64}, {70, 74}};
    EXPECT_EQ(predict_cycle(can, requests, bits), 60us + 70us + 3ms - 3us + 74us);
}

TEST(Predict, ABusyCanHidesAllResponses)
{
    std::vector<wire::Request> many;
    for (int id = 0; id <= 9; ++id)
        many.push_back(ask(id, fake::CanRead{}, 20us));
    EXPECT_EQ(predict_cycle(can, many), 20 * frame_time(can, 2));
}

TEST(Predict, AStopWaitsForTheLongestExchangeOnASerialLineAndForAllFramesOnCan)
{
    const std::vector running{ask(1, fake::Read{}, 1ms), ask(2, fake::Read{}, 3ms)};
    auto broadcast = ask(9, fake::Set{});
    broadcast.answered = false;
    const std::vector stop{broadcast, ask(1, fake::Set{}, 1ms)};
    const StopBound bound = predict_stop(serial, running, stop);
    EXPECT_EQ(bound.begins, 3ms + 800us);
    EXPECT_EQ(bound.first, bound.begins + 400us);
    EXPECT_EQ(bound.ends, bound.begins + 400us + 1800us);

    const std::vector queued{ask(1, fake::CanRead{}, 1ms), ask(2, fake::CanRead{}, 3ms)};
    EXPECT_EQ(predict_stop(can, queued, {}).begins, 4 * frame_time(can, 2) + 3ms);
    EXPECT_EQ(predict_stop(can, queued, {}).ends, 4 * frame_time(can, 2) + 3ms);
    const std::vector in_turn{ask(1, fake::CanRead{}, 1ms), ask(2, fake::CanRead{}, 3ms), ask(1, fake::CanRead{}, 2ms)};
    EXPECT_EQ(predict_stop(can, in_turn, {}).begins, 4 * frame_time(can, 2) + 3ms) << "one outstanding per identifier";
    EXPECT_EQ(predict_stop(serial, {}, stop).begins, 0ms);
    const std::vector one_by_one{ask(1, fake::CanRead{}, 1ms), ask(1, fake::CanRead{}, 3ms)};
    EXPECT_EQ(predict_stop(can, {}, one_by_one).ends, 4 * frame_time(can, 2) + 4ms) << "the second waits for the first";
}

TEST(Predict, AStopWaitsForOneRequestForAllMotorsOrForAllOthersWhicheverIsLonger)
{
    const auto all = ask(0, fake::ReadAll{});
    const Duration alone = frame_time(can, 2) + 4 * frame_time(can, 2);
    EXPECT_EQ(predict_stop(can, std::vector{all, ask(1, fake::CanRead{})}, {}).begins, alone);
    EXPECT_EQ(
        predict_stop(
            can, std::vector{ask(1, fake::CanRead{}), all, ask(2, fake::CanRead{}), all, ask(3, fake::CanRead{})}, {})
            .begins,
        6 * frame_time(can, 2));
}

} // namespace
} // namespace sinew::bus
