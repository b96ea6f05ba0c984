#include "sinew/link/can_ids.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace sinew::link {
namespace {

std::vector<IdFilter> filters(std::string_view text)
{
    const auto parsed = parse_can_ids(text);
    EXPECT_TRUE(parsed) << text;
    return parsed.value_or(std::vector<IdFilter>{});
}

TEST(CanIds, PassWhatIsListedAndNothingElse)
{
    const auto all = filters("141-160,280");
    for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
        const bool passed = std::ranges::any_of(all, [&](const IdFilter& f) { return f.passes(id); });
        EXPECT_EQ(passed, (id >= 0x141 && id <= 0x160) || id == 0x280) << id;
    }
}

TEST(CanIds, EveryRangeIsExactWithFewFilters)
{
    for (std::uint32_t first = 0; first <= 0x7FF; first += 13)
        for (std::uint32_t last = first; last <= 0x7FF; last += 17) {
            std::array<char, 16> text{};
            const int size = std::snprintf(text.data(), text.size(), "%X-%x", first, last);
            const auto all = filters({text.data(), static_cast<std::size_t>(size)});
            ASSERT_LE(all.size(), 20u);
            std::size_t passed = 0;
            for (const IdFilter& filter : all) // the blocks do not overlap, so their sizes add up
                passed += (0x7FFu & ~filter.mask) + 1;
            ASSERT_EQ(passed, last - first + 1);
            ASSERT_TRUE(all.front().passes(first));
            ASSERT_TRUE(all.back().passes(last));
        }
}

TEST(CanIds, AllIdentifiersAreOneFilter)
{
    EXPECT_EQ(filters("0-7FF"), (std::vector<IdFilter>{{.id = 0, .mask = 0}}));
    EXPECT_EQ(filters("141"), (std::vector<IdFilter>{{.id = 0x141, .mask = 0x7FF}}));
}

TEST(CanIds, RefuseWhatIsNoIdentifier)
{
    for (const std::string_view text : {"", "800", "xyz", "160-141", "141,", ",141", "141-", "-141", "0x141", "141 "}) {
        const auto parsed = parse_can_ids(text);
        ASSERT_FALSE(parsed) << text;
        EXPECT_EQ(parsed.error().code, Errc::bad_uri) << text;
    }
    EXPECT_EQ(to_sentence(parse_can_ids("141,800").error()),
              "option ids takes identifiers in hex from 0 to 7FF, such as ids=141-160,280; '800' is none");
}

TEST(CanIds, AreAddedToALinkThatHearsAllOfACanInterface)
{
    const std::uint32_t ids[] = {0x141, 0x1A, 0x241};
    EXPECT_EQ(with_can_ids("can:can0", ids), "can:can0?ids=141,1A,241");
    EXPECT_EQ(with_can_ids("can:can0?bitrate=1000000", ids), "can:can0?bitrate=1000000&ids=141,1A,241");
    EXPECT_EQ(parse_can_ids("141,1A,241").value().size(), 3U);
    for (const std::string link : {"can:can0?ids=7FF", "slcan:/dev/ttyACM0", "sim:arm.toml#legs", "nonsense"})
        EXPECT_EQ(with_can_ids(link, ids), link);
    EXPECT_EQ(with_can_ids("can:can0", {}), "can:can0");
}

} // namespace
} // namespace sinew::link
