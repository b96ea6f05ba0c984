#pragma once
#include "tests/support/random.hpp"

#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <malloc.h>

/// Whether a program that does the same many times, such as losing a link, holds no more and more. SINEW_REPLUGS is how
/// often.
namespace sinew::test {

inline constexpr int warm_up = 10;

inline int replugs()
{
    return static_cast<int>(setting("SINEW_REPLUGS", 100));
}

/// What this program holds: descriptors, and bytes of the heap (0 under a sanitizer, which looks for leaks itself).
struct Held {
    std::ptrdiff_t descriptors = 0;
    std::size_t heap = 0;
    static Held now()
    {
        return {std::distance(std::filesystem::directory_iterator{"/proc/self/fd"}, {}), ::mallinfo2().uordblks};
    }
};

/// After `warm_up` rounds there are as many descriptors as at the end, and no more of the heap than a sentence or two
/// that got longer. A connection that the other thread is just about to take or to close may be counted or not:
/// `in_passing` of them; a leak would be one a round.
class Leaks
{
public:
    explicit Leaks(std::ptrdiff_t in_passing) : in_passing_(in_passing) {}
    void round(int number)
    {
        if (number == warm_up)
            before_ = Held::now();
    }
    ~Leaks()
    {
        const Held after = Held::now();
        EXPECT_LE(std::abs(after.descriptors - before_.descriptors), in_passing_);
        EXPECT_LE(after.heap, before_.heap + 4096 + static_cast<std::size_t>(in_passing_) * of_a_connection);
        fmt::print("{} descriptors before and {} after, {} bytes of heap before and {} after\n", before_.descriptors,
                   after.descriptors, before_.heap, after.heap);
    }

private:
    /// Its buffers grow with what came at once, for some hundred rounds, and then no more.
    static constexpr std::size_t of_a_connection = 16384;
    std::ptrdiff_t in_passing_;
    Held before_ = Held::now();
};

} // namespace sinew::test
