#include "sinew/wire/select.hpp"
#include "tests/property/sides.hpp"

#include <gtest/gtest.h>

/// The short ways say what the long ones say.
namespace sinew::property {
namespace {

using namespace wire;
using test::Random;

/// A frame of one message, or one that differs from it by a bit or two, by its length or by its identifier.
Frame nearly(const NamedSide& side, Random& random)
{
    const Sample x = sample(*side.message, side.direction, random);
    Frame frame = *encode(*side.message, side.direction, x.id, x.values, x.options);
    for (std::uint64_t flips = random.below(3); flips > 0; --flips)
        frame.data[random.below(frame.size)] ^= static_cast<std::uint8_t>(1U << random.below(8));
    if (random.one_in(8) && frame.size < Frame::capacity)
        ++frame.size;
    if (random.one_in(8) && frame.size > 1)
        frame.data[--frame.size] = 0;
    if (frame.can_id != 0 && random.one_in(4))
        frame.can_id ^= 1U << random.below(6);
    return frame;
}

TEST(Selection, ByEightBytesAtOnceSaysWhatTheFieldsSay)
{
    Random random("selection");
    std::uint64_t selected = 0;
    for (const auto& side : all_sides())
        for (std::uint64_t i = 0; i < test::cases() / 10; ++i) {
            const Frame frame = nearly(side, random);
            const Side& of = side.message->side(side.direction);
            const bool by_fields = wire::detail::selects_by_fields(of, frame);
            ASSERT_EQ(selects(of, frame), by_fields) << test_name(side) << ' ' << to_hex(frame.bytes());
            selected += by_fields ? 1 : 0;
        }
    EXPECT_GT(selected, 0U);
}

TEST(Answer, InOneStepIsWhatFramingAndMatchingSay)
{
    Random random("answer");
    std::uint64_t taken = 0;
    for (const auto& side : all_sides()) {
        const MessageInfo& message = *side.message;
        if (side.direction != Direction::reply || !message.request.exists())
            continue;
        for (std::uint64_t i = 0; i < test::cases() / 10; ++i) {
            const Sample x = sample(message, Direction::request, random);
            const Frame asked = *encode(message, Direction::request, x.id, x.values, x.options);
            Frame reply = nearly(side, random);
            if (side.family->name == "nuri" && random.one_in(2)) { // the right device, so that the rest decides
                reply.data[2] = asked.data[2];
                if (random.one_in(2) && reply.size >= message.reply.size)
                    seal(message.reply, reply);
            }
            const Protocol& protocol = *side.family->protocol;
            const Scan scan = protocol.find_reply(reply.bytes(), message.reply.size, false);
            const bool is_framed = reply.can_id != 0 || (scan.skip == 0 && scan.size == reply.size);
            const bool by_steps = is_framed && protocol.answers(asked, message, reply, x.options);
            ASSERT_EQ(protocol.is_answer(asked, message, reply, x.options), by_steps)
                << test_name(side) << ' ' << to_hex(reply.bytes());
            taken += by_steps ? 1 : 0;
        }
    }
    EXPECT_GT(taken, test::cases());
}

TEST(Sum, OfSeveralBytesAtOnceIsTheirSum)
{
    Random random("sum");
    for (std::size_t size = 0; size <= 64; ++size)
        for (int i = 0; i < 200; ++i) {
            std::array<std::uint8_t, 64> bytes{};
            unsigned sum = 0;
            for (std::size_t k = 0; k < bytes.size(); ++k) {
                bytes[k] = random.one_in(4) ? 0xFF : random.byte();
                sum += k < size ? bytes[k] : 0;
            }
            ASSERT_EQ(sum_of(bytes.data(), size), sum) << size;
        }
}

TEST(FrameOf, BytesHasThemAndNothingElse)
{
    Random random("frame");
    for (std::size_t size = 0; size <= Frame::capacity; ++size) {
        std::array<std::uint8_t, Frame::capacity> bytes{};
        for (auto& byte : bytes)
            byte = random.byte();
        const Frame frame = Frame::of(std::span(bytes).first(size));
        EXPECT_EQ(frame.size, size);
        for (std::size_t i = 0; i < Frame::capacity; ++i)
            EXPECT_EQ(frame.data[i], i < size ? bytes[i] : 0) << size << ' ' << i;
    }
}

} // namespace
} // namespace sinew::property
