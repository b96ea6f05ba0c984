#include "sinew/record/crc32.hpp"

#include "sinew/record/little_endian.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace sinew::record {
namespace {

TEST(Crc32, IsThatOfTheStandardsCheckWord)
{
    EXPECT_EQ(crc32(bytes_of("123456789")), 0xCBF4'3926U);
    EXPECT_EQ(crc32({}), 0U);
}

TEST(Crc32, OfPartsIsThatOfTheWholeWhereverItIsCut)
{
    std::vector<std::uint8_t> bytes;
    for (unsigned i = 0; i < 100; ++i)
        bytes.push_back(static_cast<std::uint8_t>(i * 37 + 11));
    const auto whole = crc32(bytes);
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
        const auto all = std::span<const std::uint8_t>(bytes);
        EXPECT_EQ(crc32(all.subspan(cut), crc32(all.first(cut))), whole) << cut;
    }
}

} // namespace
} // namespace sinew::record
