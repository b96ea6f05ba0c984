#include "sinew/wire/frame.hpp"

#include <gtest/gtest.h>
#include <numeric>
#include <vector>

namespace sinew::wire {
namespace {

std::vector<std::uint8_t> counting(std::size_t size)
{
    std::vector<std::uint8_t> bytes(size);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
    return bytes;
}

TEST(Frame, TakesOverBytesOfEverySizeAndClearsTheRest)
{
    for (std::size_t size = 0; size <= Frame::capacity; ++size) {
        // In the middle of other bytes, so that one too many would be seen.
        std::vector<std::uint8_t> around(size + 32, 0xEE);
        const auto bytes = counting(size);
        std::copy(bytes.begin(), bytes.end(), around.begin() + 16);
        Frame frame{.can_id = 5, .size = 3};
        frame.data.fill(0xCC);
        frame.assign(std::span(around).subspan(16, size));
        EXPECT_EQ(frame.can_id, 0U);
        EXPECT_EQ(frame.size, size);
        for (std::size_t i = 0; i < Frame::capacity; ++i)
            EXPECT_EQ(frame.data[i], i < size ? i + 1 : 0U) << "byte " << i << " of " << size;
        EXPECT_EQ(std::vector(frame.bytes().begin(), frame.bytes().end()), bytes);
    }
}

TEST(Frame, OneThatIsMadeOfNothingIsOneWithoutBytes)
{
    EXPECT_EQ(Frame{}, Frame::of({}));
}

TEST(Frame, IsEqualWhereIdentifierSizeAndTheBytesInUseAre)
{
    const Frame frame = Frame::of(counting(5));
    Frame other = frame;
    other.data[5] = 1; // not in use
    EXPECT_EQ(frame, other);
    for (const std::size_t byte : {0U, 2U, 4U}) {
        other = frame;
        ++other.data[byte];
        EXPECT_NE(frame, other) << byte;
    }
    other = frame;
    other.can_id = 1;
    EXPECT_NE(frame, other);
    other = frame;
    other.size = 4;
    EXPECT_NE(frame, other);
    EXPECT_EQ(Frame{}, Frame{});
}

TEST(Frame, ItsFirstEightBytesAreOneWord)
{
    const Frame frame = Frame::of(counting(9));
    std::uint64_t word = frame.first_eight();
    const std::vector<std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(&word),
                                          reinterpret_cast<const std::uint8_t*>(&word) + sizeof word);
    EXPECT_EQ(bytes, counting(8));
}

} // namespace
} // namespace sinew::wire
