#pragma once
#include "sinew/family/families.hpp"
#include "sinew/wire/values.hpp"
#include "tests/fuzz/check.hpp"
#include "tests/support/visit.hpp"

#include <algorithm>
#include <span>

/// What holds for every decoder, whatever the bytes are.
namespace sinew::fuzz {

/// The bytes of a fuzz input as a frame. The first byte chooses the options.
struct Input {
    wire::Frame frame{};
    wire::Options options{};
    bool explains_all = false; ///< also the refusals that nearly every row has for nearly every input, which is slow
};

/// `with_identifier`: two bytes of CAN identifier stand before the data.
inline Input to_input(std::span<const std::uint8_t> bytes, bool with_identifier)
{
    Input out;
    const auto take = [&]() -> std::uint8_t {
        if (bytes.empty())
            return 0;
        const std::uint8_t first = bytes.front();
        bytes = bytes.subspan(1);
        return first;
    };
    const std::uint8_t choice = take();
    out.options.bits = choice & 0x3FU;
    out.explains_all = (choice & 0x40U) != 0;
    if ((choice & 0x80U) != 0)
        out.options.can_reply_base = 0x240;
    if (with_identifier) {
        out.frame.can_id = take();
        out.frame.can_id = (out.frame.can_id << 8 | take()) & 0x7FFU;
    }
    const std::size_t size = std::min(bytes.size(), wire::Frame::capacity);
    std::copy_n(bytes.begin(), size, out.frame.data.begin());
    out.frame.size = static_cast<std::uint8_t>(size);
    return out;
}

inline void claim_refusal(const Input& in, const Error& error)
{
    const bool is_common = error.code == Errc::bad_length || error.code == Errc::bad_constant;
    if (in.explains_all || !is_common)
        claim_explained(error);
}

inline bool same_values(const wire::Values& a, const wire::Values& b)
{
    return std::ranges::equal(a.all(), b.all(), [](const wire::Value& x, const wire::Value& y) {
        return x.field == y.field && x.raw == y.raw;
    });
}

/// What decodes has values that encode to a canonical frame, which decodes to the same values and encodes to itself.
inline void claim_canonical(const wire::MessageInfo& message, wire::Direction direction, const Input& in)
{
    const auto decoded = decode(message, direction, in.frame, in.options);
    if (!decoded) {
        claim_refusal(in, decoded.error());
        return;
    }
    const auto canonical = encode(message, direction, decoded->id, decoded->values, in.options);
    SINEW_CLAIM(canonical.has_value());
    SINEW_CLAIM(canonical->size == in.frame.size);
    const auto again = decode(message, direction, *canonical, in.options);
    SINEW_CLAIM(again.has_value());
    SINEW_CLAIM(again->id == decoded->id);
    SINEW_CLAIM(same_values(again->values, decoded->values));
    const auto same = encode(message, direction, again->id, again->values, in.options);
    SINEW_CLAIM(same && *same == *canonical);
}

/// Every row of every firmware line of a family.
inline void claim_all_rows(const Family& family, const Input& in)
{
    for (const auto* profile : family.profiles) {
        for (const auto* message : profile->messages)
            for (const auto direction : {wire::Direction::request, wire::Direction::reply})
                if (message->side(direction).exists())
                    claim_canonical(*message, direction, in);
        for (const auto direction : {wire::Direction::request, wire::Direction::reply})
            if (const auto* message = family.protocol->identify(in.frame, direction, *profile)) {
                SINEW_CLAIM(profile->has(*message));
                SINEW_CLAIM(message->side(direction).exists());
            }
    }
}

/// The typed codec takes and refuses the same frames as the one by name, and says the same.
template <class List>
void claim_typed(const Input& in)
{
    test::for_each_side(List{}, [&]<class M, wire::Direction D>() {
        const wire::MessageInfo& message = wire::info_of<M>;
        const auto typed = test::decode_side<M, D>(in.frame, in.options);
        const auto named = decode(message, D, in.frame, in.options);
        SINEW_CLAIM(typed.has_value() == named.has_value());
        if (!typed) {
            claim_refusal(in, typed.error());
            return;
        }
        SINEW_CLAIM(typed->id == named->id);
        const auto frame = test::encode_side<M, D>(typed->id, typed->message, in.options);
        SINEW_CLAIM(frame.has_value());
        const auto values = decode(message, D, *frame, in.options);
        SINEW_CLAIM(values && same_values(values->values, named->values));
    });
}

} // namespace sinew::fuzz
