#pragma once
#include "sinew/wire/field.hpp"

#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>

/// Random values with a seed that is printed, so that every failure can be run again.
namespace sinew::test {

/// A whole number from the environment.
inline std::uint64_t setting(const char* name, std::uint64_t otherwise)
{
    const char* text = std::getenv(name);
    return text == nullptr || *text == '\0' ? otherwise : std::strtoull(text, nullptr, 0);
}

/// SINEW_SEED, or one that differs from run to run.
inline std::uint64_t seed()
{
    static const std::uint64_t the_seed = setting("SINEW_SEED", std::random_device{}());
    return the_seed;
}

/// SINEW_CASES, the number of cases per message.
inline std::uint64_t cases()
{
    return setting("SINEW_CASES", 10'000);
}

class Random
{
public:
    /// Each test draws from its own stream, whatever ran before it.
    explicit Random(std::string_view test) : engine_(seed() ^ std::hash<std::string_view>{}(test)) {}

    std::uint64_t bits() { return engine_(); }
    std::uint64_t below(std::uint64_t count) { return engine_() % count; }
    bool one_in(std::uint64_t count) { return below(count) == 0; }

    /// A value of the range; its ends and their neighbours come up often.
    std::int64_t in(const wire::Range& range)
    {
        const auto width = static_cast<std::uint64_t>(range.high) - static_cast<std::uint64_t>(range.low);
        const std::uint64_t step = width == 0 ? 0 : below(2) * (width > 1 ? below(2) : 0);
        switch (below(8)) {
        case 0:
            return range.low + static_cast<std::int64_t>(step);
        case 1:
            return range.high - static_cast<std::int64_t>(step);
        default:
            return range.low + static_cast<std::int64_t>(width == ~std::uint64_t{0} ? bits() : below(width + 1));
        }
    }

    /// A value of `outer` that is not in `inner`. There must be one.
    std::int64_t outside(const wire::Range& inner, const wire::Range& outer)
    {
        const bool can_be_low = outer.low < inner.low;
        const bool can_be_high = outer.high > inner.high;
        if (can_be_low && (!can_be_high || one_in(2)))
            return in({outer.low, inner.low - 1});
        return in({inner.high + 1, outer.high});
    }

    std::uint8_t byte() { return static_cast<std::uint8_t>(bits()); }

private:
    std::mt19937_64 engine_;
};

} // namespace sinew::test
