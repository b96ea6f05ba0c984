#include "sinew/record/ring.hpp"

#include "tests/support/allocations.hpp"

#include <deque>
#include <gtest/gtest.h>
#include <random>
#include <thread>
#include <vector>

namespace sinew::record {
namespace {

bool push(Ring& ring, std::size_t bytes, std::uint8_t fill)
{
    std::byte* place = ring.reserve(bytes);
    if (place == nullptr)
        return false;
    std::memset(place, fill, bytes);
    ring.commit();
    return true;
}

TEST(Ring, GivesBackInOrderWhatWasPutInWhateverItsSize)
{
    const auto seed = std::random_device{}();
    std::mt19937 random(seed);
    Ring ring(4096);
    std::deque<std::pair<std::size_t, std::uint8_t>> expected;
    std::uint8_t next = 0;
    std::size_t refused = 0;
    for (int i = 0; i < 100'000; ++i) {
        const std::size_t bytes = random() % 300;
        if (random() % 2 != 0) {
            if (push(ring, bytes, next))
                expected.emplace_back(bytes, next++);
            else
                ++refused;
            continue;
        }
        const auto got = ring.front();
        ASSERT_EQ(got.data() == nullptr, expected.empty()) << "seed " << seed;
        if (expected.empty())
            continue;
        ASSERT_EQ(got.size(), expected.front().first) << "seed " << seed;
        for (const std::byte byte : got)
            ASSERT_EQ(byte, std::byte{expected.front().second}) << "seed " << seed;
        ASSERT_EQ(reinterpret_cast<std::uintptr_t>(got.data()) % 8, 0U);
        expected.pop_front();
        ring.pop();
    }
    EXPECT_GT(refused, 0U) << "seed " << seed;
}

TEST(Ring, IsFullWhenItIsFullAndTakesMoreOnceSomethingWasRead)
{
    Ring ring(4096);
    int count = 0;
    while (push(ring, 56, 1))
        ++count;
    EXPECT_EQ(count, 4096 / 64);
    EXPECT_EQ(ring.in_use(), 4096U);
    EXPECT_FALSE(push(ring, 1, 1));
    ring.front();
    ring.pop();
    EXPECT_TRUE(push(ring, 56, 1));
    EXPECT_FALSE(push(ring, 4096, 1));
}

TEST(Ring, TakesEntriesFromAnotherThreadWithoutTheHeap)
{
    Ring ring(1 << 14);
    constexpr std::uint64_t count = 50'000;
    std::thread writer([&] {
        for (std::uint64_t i = 0; i < count;) {
            std::byte* place = ring.reserve(8 + i % 50);
            if (place == nullptr)
                continue;
            std::memcpy(place, &i, sizeof i);
            ring.commit();
            ++i;
        }
    });
    const auto before = support::allocations();
    for (std::uint64_t expected = 0; expected < count;) {
        const auto got = ring.front();
        if (got.data() == nullptr)
            continue;
        std::uint64_t value = 0;
        std::memcpy(&value, got.data(), sizeof value);
        ASSERT_EQ(value, expected);
        ASSERT_EQ(got.size(), 8 + expected % 50);
        ring.pop();
        ++expected;
    }
    EXPECT_EQ(support::allocations(), before);
    writer.join();
}

} // namespace
} // namespace sinew::record
