#include "sinew/base/bytes.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/family/sam/messages.hpp"
#include "tests/support/random.hpp"
#include "tests/support/visit.hpp"

#include <gtest/gtest.h>

/// The typed codec: every struct of the manuals in both directions.
namespace sinew::property {
namespace {

using namespace wire;
using test::Random;
using test::ValueOf;

template <class M, Direction D, std::size_t I>
using PartOf = std::remove_cvref_t<decltype(std::get<I>(wire::detail::typed_side<M, D>().parts))>;

template <class M, Direction D>
inline constexpr std::size_t part_count =
    std::tuple_size_v<std::remove_cvref_t<decltype(wire::detail::typed_side<M, D>().parts)>>;

/// All that a member can hold.
template <class T>
constexpr Range holds()
{
    if constexpr (std::is_enum_v<T>)
        return holds<std::underlying_type_t<T>>();
    else if constexpr (std::is_same_v<T, bool>)
        return {0, 1};
    else if constexpr (std::is_same_v<T, std::uint64_t>)
        return {0, std::numeric_limits<std::int64_t>::max()};
    else
        return {std::numeric_limits<T>::min(), std::numeric_limits<T>::max()};
}

template <class M, Direction D, std::size_t I>
void fill(ValueOf<M, D>& value, Options options, Random& random)
{
    constexpr const auto& part = std::get<I>(wire::detail::typed_side<M, D>().parts);
    constexpr Field f = wire::detail::field_of(part);
    if constexpr (f.kind == Kind::sequence) {
        for (std::size_t i = 0; i < value.*part.count; ++i)
            (value.*part.member)[i] = {static_cast<std::uint8_t>(random.in(f.range)),
                                       static_cast<std::uint8_t>(random.in(f.range))};
    } else if constexpr (!std::is_same_v<PartOf<M, D, I>, Field>) {
        if (f.when.holds(options))
            value.*part.member = static_cast<typename PartOf<M, D, I>::Member>(random.in(allowed(f)));
    }
}

template <class M, Direction D, std::size_t I>
bool same(const ValueOf<M, D>& a, const ValueOf<M, D>& b)
{
    constexpr const auto& part = std::get<I>(wire::detail::typed_side<M, D>().parts);
    if constexpr (wire::detail::field_of(part).kind == Kind::sequence) {
        for (std::size_t i = 0; i < a.*part.count; ++i)
            if ((a.*part.member)[i] != (b.*part.member)[i])
                return false;
        return true;
    } else if constexpr (!std::is_same_v<PartOf<M, D, I>, Field>) {
        return a.*part.member == b.*part.member;
    }
    return true;
}

template <class M, Direction D>
struct Drawn {
    int id = -1;
    ValueOf<M, D> value{};
    Options options{};
};

template <class M, Direction D, std::size_t... I>
Drawn<M, D> draw(Random& random, std::index_sequence<I...>)
{
    Drawn<M, D> out;
    for (const Field& f : info_of<M>.side(D).fields)
        if (random.one_in(2))
            out.options.bits |= f.when.mask;
    const Side& side = info_of<M>.side(D);
    for (const Field& f : side.fields)
        if (f.kind == Kind::address)
            out.id = static_cast<int>(random.in(allowed(f)));
    if (side.layout->can_base != 0 && !side.layout->can_fixed)
        out.id = static_cast<int>(random.in(side.layout->ids));
    (fill<M, D, I>(out.value, out.options, random), ...);
    return out;
}

template <class M, Direction D, std::size_t... I>
void decodes_what_it_encoded(Random& random, std::index_sequence<I...> parts)
{
    for (std::uint64_t i = 0; i < test::cases(); ++i) {
        const auto x = draw<M, D>(random, parts);
        const auto frame = test::encode_side<M, D>(x.id, x.value, x.options);
        ASSERT_TRUE(frame) << to_sentence(frame.error());
        const auto decoded = test::decode_side<M, D>(*frame, x.options);
        ASSERT_TRUE(decoded) << to_sentence(decoded.error());
        ASSERT_EQ(decoded->id, x.id);
        ASSERT_TRUE((same<M, D, I>(decoded->message, x.value) && ...)) << to_hex(frame->bytes());
    }
}

/// Spoils one member, if its type holds more than may travel.
template <class M, Direction D, std::size_t I>
void refuses_out_of_range(Random& random)
{
    constexpr const auto& part = std::get<I>(wire::detail::typed_side<M, D>().parts);
    constexpr Field f = wire::detail::field_of(part);
    if constexpr (f.kind != Kind::sequence && !std::is_same_v<PartOf<M, D, I>, Field>) {
        using Member = typename PartOf<M, D, I>::Member;
        constexpr Range range = allowed(f);
        constexpr Range all = holds<Member>();
        if constexpr (all.low < range.low || all.high > range.high) {
            for (std::uint64_t i = 0; i < test::cases() / 20; ++i) {
                auto x = draw<M, D>(random, std::make_index_sequence<part_count<M, D>>{});
                x.options.bits = f.when.equals;
                const std::int64_t bad = random.outside(range, all);
                x.value.*part.member = static_cast<Member>(bad);
                const auto frame = test::encode_side<M, D>(x.id, x.value, x.options);
                ASSERT_FALSE(frame) << info_of<M>.name() << " " << f.name << " " << bad;
                ASSERT_EQ(frame.error().code, Errc::out_of_range);
                ASSERT_EQ(frame.error().message, info_of<M>.name());
                ASSERT_EQ(frame.error().field, f.name);
                ASSERT_EQ(frame.error().value, bad);
                ASSERT_EQ(frame.error().low, range.low);
                ASSERT_EQ(frame.error().high, range.high);
            }
        }
    }
}

template <class List>
void all_decode_what_they_encoded(std::string_view name)
{
    Random random(name);
    test::for_each_side(List{}, [&]<class M, Direction D>() {
        SCOPED_TRACE(info_of<M>.name());
        decodes_what_it_encoded<M, D>(random, std::make_index_sequence<part_count<M, D>>{});
    });
}

template <class List>
void all_refuse_out_of_range(std::string_view name)
{
    Random random(name);
    test::for_each_side(List{}, [&]<class M, Direction D>() {
        [&]<std::size_t... I>(std::index_sequence<I...>) {
            (refuses_out_of_range<M, D, I>(random), ...);
        }(std::make_index_sequence<part_count<M, D>>{});
    });
}

TEST(TypedCodec, DecodesEverySamMessageItEncoded)
{
    all_decode_what_they_encoded<sam::ManualMessages>("sam");
}

TEST(TypedCodec, DecodesEveryNuriMessageItEncoded)
{
    all_decode_what_they_encoded<nuri::ManualMessages>("nuri");
}

TEST(TypedCodec, DecodesEveryRmdMessageItEncoded)
{
    all_decode_what_they_encoded<rmd::ManualMessages>("rmd");
}

TEST(TypedCodec, RefusesEverySamMemberOutOfRangeAndNamesIt)
{
    all_refuse_out_of_range<sam::ManualMessages>("sam");
}

TEST(TypedCodec, RefusesEveryNuriMemberOutOfRangeAndNamesIt)
{
    all_refuse_out_of_range<nuri::ManualMessages>("nuri");
}

TEST(TypedCodec, RefusesEveryRmdMemberOutOfRangeAndNamesIt)
{
    all_refuse_out_of_range<rmd::ManualMessages>("rmd");
}

} // namespace
} // namespace sinew::property
