#include "tests/property/sides.hpp"

#include <gtest/gtest.h>

/// The codec by name: every message of the manuals in both directions.
namespace sinew::property {
namespace {

using namespace wire;
using test::Random;

class ByName : public testing::TestWithParam<NamedSide>
{
};

TEST_P(ByName, DecodesWhatItEncoded)
{
    const auto& [family, message, direction] = GetParam();
    Random random(testing::UnitTest::GetInstance()->current_test_info()->name());
    const auto again = family->again(*message, direction);
    for (std::uint64_t i = 0; i < test::cases(); ++i) {
        const Sample x = sample(*message, direction, random);
        const auto frame = encode(*message, direction, x.id, x.values, x.options);
        ASSERT_TRUE(frame) << to_sentence(frame.error());
        const auto decoded = decode(*message, direction, *frame, x.options);
        ASSERT_TRUE(decoded) << to_sentence(decoded.error());
        ASSERT_EQ(decoded->id, x.id);
        ASSERT_TRUE(same_values(decoded->values, x.values)) << to_hex(frame->bytes());
        const auto typed = again(*frame, x.options);
        ASSERT_TRUE(typed) << to_sentence(typed.error());
        ASSERT_TRUE(*typed == *frame) << to_hex(frame->bytes()) << " and " << to_hex(typed->bytes());
    }
}

TEST_P(ByName, RefusesToEncodeAValueOutOfRangeAndNamesIt)
{
    const auto& [family, message, direction] = GetParam();
    Random random(testing::UnitTest::GetInstance()->current_test_info()->name());
    for (std::uint64_t i = 0; i < test::cases() / 4; ++i) {
        Sample x = sample(*message, direction, random);
        if (x.values.all().empty())
            return;
        const std::size_t at = random.below(x.values.all().size());
        const Field& f = *x.values.all()[at].field;
        const Range range = f.kind == Kind::sequence ? f.range : allowed(f);
        const std::int64_t bad = random.outside(range, {range.low - 100'000, range.high + 100'000});
        x.values = with(x.values, at, bad);
        const auto frame = encode(*message, direction, x.id, x.values, x.options);
        ASSERT_FALSE(frame);
        ASSERT_TRUE(names(frame.error(), *message, f, bad)) << to_sentence(frame.error());
    }
}

TEST_P(ByName, RefusesToDecodeAValueOutOfRangeAndNamesIt)
{
    const auto& [family, message, direction] = GetParam();
    Random random(testing::UnitTest::GetInstance()->current_test_info()->name());
    const auto again = family->again(*message, direction);
    for (std::uint64_t i = 0; i < test::cases() / 4; ++i) {
        const Sample x = sample(*message, direction, random);
        const auto narrow = narrow_values(x.values);
        if (narrow.empty())
            return;
        const std::size_t at = narrow[random.below(narrow.size())];
        const Field& f = *x.values.all()[at].field;
        const std::int64_t bad = random.outside(allowed(f), capacity(f));
        const auto frame = encode(*message, direction, x.id, x.values, x.options);
        ASSERT_TRUE(frame);
        const Frame broken = with_raw(*message, direction, *frame, f, bad);
        const auto decoded = decode(*message, direction, broken, x.options);
        ASSERT_FALSE(decoded) << to_hex(broken.bytes());
        ASSERT_TRUE(names(decoded.error(), *message, f, bad)) << to_sentence(decoded.error());
        const auto typed = again(broken, x.options);
        ASSERT_FALSE(typed) << to_hex(broken.bytes());
        ASSERT_TRUE(names(typed.error(), *message, f, bad)) << to_sentence(typed.error());
    }
}

TEST_P(ByName, RefusesAnIdThatTheFamilyCannotAddress)
{
    const auto& [family, message, direction] = GetParam();
    Random random(testing::UnitTest::GetInstance()->current_test_info()->name());
    const Range ids = ids_of(*message, direction);
    if (!ids.given())
        return;
    for (std::uint64_t i = 0; i < test::cases() / 10; ++i) {
        const Sample x = sample(*message, direction, random);
        const auto bad = static_cast<int>(random.outside(ids, {-1000, 1000}));
        const auto frame = encode(*message, direction, bad, x.values, x.options);
        ASSERT_FALSE(frame);
        ASSERT_EQ(frame.error().code, Errc::bad_id);
        ASSERT_EQ(frame.error().value, bad);
        ASSERT_EQ(frame.error().low, ids.low);
        ASSERT_EQ(frame.error().high, ids.high);
    }
}

TEST_P(ByName, RefusesAMissingFieldAndNamesIt)
{
    const auto& [family, message, direction] = GetParam();
    Random random(testing::UnitTest::GetInstance()->current_test_info()->name());
    const Sample x = sample(*message, direction, random);
    for (std::size_t at = 0; at < x.values.all().size(); ++at) {
        const Field& f = *x.values.all()[at].field;
        if (f.kind == Kind::sequence)
            continue;
        const auto frame = encode(*message, direction, x.id, without(x.values, at), x.options);
        ASSERT_FALSE(frame);
        EXPECT_EQ(frame.error().code, Errc::missing_field);
        EXPECT_EQ(frame.error().field, f.name);
    }
}

TEST_P(ByName, RefusesAFrameOfAnotherLength)
{
    const auto& [family, message, direction] = GetParam();
    Random random(testing::UnitTest::GetInstance()->current_test_info()->name());
    const auto again = family->again(*message, direction);
    const Sample x = sample(*message, direction, random);
    const auto frame = encode(*message, direction, x.id, x.values, x.options);
    ASSERT_TRUE(frame);
    for (std::uint8_t size = 0; size <= Frame::capacity; ++size) {
        if (size == frame->size)
            continue;
        Frame other = *frame;
        other.size = size;
        EXPECT_FALSE(decode(*message, direction, other, x.options)) << int{size};
        EXPECT_FALSE(again(other, x.options)) << int{size};
    }
}

INSTANTIATE_TEST_SUITE_P(Messages, ByName, testing::ValuesIn(all_sides()),
                         [](const auto& tested) { return test_name(tested.param); });

} // namespace
} // namespace sinew::property
