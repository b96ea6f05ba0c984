#include "tests/property/stream.hpp"

#include <gtest/gtest.h>

/// Framing: what is found in a stream of bytes, whatever the port makes of it.
namespace sinew::property {
namespace {

using namespace wire;
using test::Random;

std::uint64_t stream_cases()
{
    return test::cases() * 5;
}

void append(std::vector<std::uint8_t>& stream, const std::vector<std::uint8_t>& bytes)
{
    stream.insert(stream.end(), bytes.begin(), bytes.end());
}

std::vector<Found> in_one_piece(const Listener& listener, const std::vector<std::uint8_t>& stream)
{
    Receiver receiver(listener);
    receiver.hear(stream);
    receiver.fall_silent();
    return receiver.found();
}

std::vector<Found> in_pieces(const Listener& listener, const std::vector<std::uint8_t>& stream, Random& random)
{
    Receiver receiver(listener);
    const std::uint64_t longest = 1 + random.below(8);
    for (std::size_t at = 0; at < stream.size();) {
        const std::size_t size = std::min<std::size_t>(1 + random.below(longest), stream.size() - at);
        receiver.hear(std::span(stream).subspan(at, size));
        at += size;
    }
    receiver.fall_silent();
    return receiver.found();
}

TEST(Framing, FindsTheSameFramesHoweverTheStreamIsCut)
{
    for (const auto& listener : listeners()) {
        Random random("cut");
        SCOPED_TRACE(listener.name());
        for (std::uint64_t i = 0; i < stream_cases(); ++i) {
            std::vector<std::uint8_t> stream;
            for (std::uint64_t parts = 1 + random.below(5); parts > 0; --parts)
                append(stream, random.one_in(3) ? garbage(listener, random) : any_frame(listener, random));
            ASSERT_EQ(in_pieces(listener, stream, random), in_one_piece(listener, stream)) << to_hex(stream);
        }
    }
}

TEST(Framing, FindsEveryFrameOfACleanStream)
{
    for (const auto& listener : listeners()) {
        Random random("clean");
        SCOPED_TRACE(listener.name());
        for (std::uint64_t i = 0; i < stream_cases(); ++i) {
            std::vector<std::uint8_t> stream;
            std::vector<Found> sent;
            for (std::uint64_t frames = 1 + random.below(5); frames > 0; --frames) {
                sent.push_back({stream.size(), any_frame(listener, random)});
                append(stream, sent.back().bytes);
            }
            ASSERT_EQ(in_pieces(listener, stream, random), sent) << to_hex(stream);
        }
    }
}

TEST(Framing, FindsAFrameAfterGarbageOnceTheLineHasBeenSilent)
{
    for (const auto& listener : listeners()) {
        Random random("silence");
        SCOPED_TRACE(listener.name());
        for (std::uint64_t i = 0; i < stream_cases(); ++i) {
            const auto before = garbage(listener, random);
            const auto frame = any_frame(listener, random);
            Receiver receiver(listener);
            receiver.hear(before);
            receiver.fall_silent();
            receiver.hear(frame);
            ASSERT_FALSE(receiver.found().empty()) << to_hex(before) << " | " << to_hex(frame);
            ASSERT_EQ(receiver.found().back(), (Found{before.size(), frame}))
                << to_hex(before) << " | " << to_hex(frame);
        }
    }
}

TEST(Framing, LosesAFrameOnlyWhereGarbageBeforeItCompletesToOneThatIsValid)
{
    for (const auto& listener : listeners()) {
        Random random("lost");
        SCOPED_TRACE(listener.name());
        std::uint64_t lost = 0;
        for (std::uint64_t i = 0; i < stream_cases(); ++i) {
            const auto before = garbage(listener, random);
            const auto frame = any_frame(listener, random);
            auto stream = before;
            append(stream, frame);
            const auto found = in_pieces(listener, stream, random);
            const Found meant{before.size(), frame};
            bool is_found = false;
            bool is_swallowed = false;
            for (const auto& one : found) {
                is_found = is_found || one == meant;
                is_swallowed = is_swallowed || (one.at < meant.at && one.at + one.bytes.size() > meant.at);
            }
            ASSERT_NE(is_found, is_swallowed) << to_hex(before) << " | " << to_hex(frame);
            lost += is_swallowed ? 1 : 0;
        }
        EXPECT_LT(lost, stream_cases() / 20);
    }
}

TEST(Framing, HandsOutBareRepliesByTheirCountAlone)
{
    Random random("bare");
    for (const std::size_t awaited : {2, 3}) {
        const Listener host{&test::family("sam"), Direction::reply, awaited};
        for (std::uint64_t i = 0; i < stream_cases() / 10; ++i) {
            std::vector<std::uint8_t> stream(awaited);
            for (auto& byte : stream)
                byte = random.byte();
            ASSERT_EQ(in_pieces(host, stream, random), (std::vector<Found>{{0, stream}})) << to_hex(stream);
        }
    }
}

} // namespace
} // namespace sinew::property
