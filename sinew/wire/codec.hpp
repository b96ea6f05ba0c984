#pragma once
#include "sinew/base/error.hpp"
#include "sinew/wire/message.hpp"

#include <cstring>
#include <expected>
#include <utility>

/// The one codec. Encoding and decoding are all or nothing: a value out of range, a wrong constant, length or checksum,
/// or a repeated value that differs is an error with its evidence; nothing is clamped. No heap, no exceptions.
namespace sinew::wire {

/// A message and the device it is for or from. `id` is -1 where the frame carries none (SAM replies).
template <class M>
struct Addressed {
    int id = -1;
    M message{};
};

namespace detail {

/// A frame with everything in it that no value changes, made at compile time.
template <class M, Direction D>
consteval Frame blank_frame()
{
    Frame frame{.can_id = 0, .size = typed_side<M, D>().size};
    for (const Field& f : fields<M, D>)
        if (f.kind == Kind::constant || f.kind == Kind::reserved || f.kind == Kind::opcode || f.kind == Kind::size)
            put(f, f.fixed, frame.data.data());
    return frame;
}

template <class M, Direction D>
inline constexpr Frame blank = blank_frame<M, D>();

/// The whole story of a failure, worked out again from the frame or value; never on the good path.
[[gnu::cold]] Error explain_id(const Info& info, const Range& ids, std::int64_t id);
[[gnu::cold]] Error explain_value(const Info& info, const Field& field, std::int64_t value);
[[gnu::cold]] Error explain_frame(const MessageInfo& message, Direction direction, const Frame& frame, Options options);

template <class M, Direction D>
consteval bool has(Kind kind)
{
    for (const Field& f : fields<M, D>)
        if (f.kind == kind)
            return true;
    return false;
}

template <class M, Direction D>
consteval Field first_of(Kind kind)
{
    for (const Field& f : fields<M, D>)
        if (f.kind == kind)
            return f;
    return {};
}

template <class M, Direction D>
consteval Range id_range()
{
    return has<M, D>(Kind::address) ? allowed(first_of<M, D>(Kind::address)) : typed_side<M, D>().layout->ids;
}

/// The field of part I with its place worked out, as a constant.
template <class M, Direction D, std::size_t I>
inline constexpr Field part_field = field_of(std::get<I>(typed_side<M, D>().parts));

template <class T>
constexpr bool fits_always(const Range& range)
{
    if constexpr (std::is_same_v<T, bool>)
        return range.contains(0) && range.contains(1);
    else if constexpr (std::is_integral_v<T> && (sizeof(T) < 8 || std::is_signed_v<T>))
        return range.contains(std::numeric_limits<T>::min()) && range.contains(std::numeric_limits<T>::max());
    else
        return false;
}

template <class M, Direction D, std::size_t I, class Value>
[[gnu::always_inline]] inline bool put_part(const Value& message, Options options, Frame& frame)
{
    constexpr const auto& part = std::get<I>(typed_side<M, D>().parts);
    using Part = std::remove_cvref_t<decltype(part)>;
    constexpr Field f = part_field<M, D, I>;
    if constexpr (f.kind == Kind::sequence) {
        const std::size_t count = message.*part.count;
        for (std::size_t i = 0; i < count; ++i) {
            const Pair pair = (message.*part.member)[i];
            if (pair.first > f.range.high || pair.second > f.range.high)
                return false;
            frame.data[f.byte + 2 * i] = pair.first;
            frame.data[f.byte + 2 * i + 1] = pair.second;
        }
        frame.size = static_cast<std::uint8_t>(frame.size + 2 * count);
    } else if constexpr (!std::is_same_v<Part, Field>) {
        if constexpr (f.when.mask != 0)
            if (!f.when.holds(options))
                return true;
        constexpr Range range = allowed(f);
        const auto value = static_cast<std::int64_t>(message.*part.member);
        if constexpr (!fits_always<typename Part::Member>(range))
            if (!range.contains(value))
                return false;
        put(f, value, frame.data.data());
    }
    return true;
}

template <class M, Direction D, std::size_t I, class Value>
[[gnu::always_inline]] inline bool get_part(const Frame& frame, Options options, Value& message)
{
    constexpr const auto& part = std::get<I>(typed_side<M, D>().parts);
    using Part = std::remove_cvref_t<decltype(part)>;
    constexpr Field f = part_field<M, D, I>;
    if constexpr (f.kind == Kind::sequence) {
        const std::size_t count = message.*part.count;
        if (frame.size != typed_side<M, D>().size + 2 * count)
            return false;
        for (std::size_t i = 0; i < count; ++i) {
            const Pair pair{frame.data[f.byte + 2 * i], frame.data[f.byte + 2 * i + 1]};
            if (pair.first > f.range.high || pair.second > f.range.high)
                return false;
            (message.*part.member)[i] = pair;
        }
    } else if constexpr (!std::is_same_v<Part, Field>) {
        if constexpr (f.when.mask != 0)
            if (!f.when.holds(options))
                return true;
        std::int64_t value{};
        if (!get(f, frame.data.data(), value))
            return false;
        constexpr Range range = allowed(f);
        constexpr Range most = capacity(f);
        if constexpr (!(range.low <= most.low && most.high <= range.high))
            if (!range.contains(value))
                return false;
        message.*part.member = static_cast<typename Part::Member>(value);
    }
    return true;
}

/// Compares every byte that must have one value.
template <class M, Direction D, std::size_t I = 0>
[[gnu::always_inline]] inline bool constants_hold(const Frame& frame)
{
    constexpr const auto& all = fields<M, D>;
    if constexpr (I == all.size()) {
        return true;
    } else {
        constexpr Field f = all[I];
        if constexpr (f.kind == Kind::opcode) {
            constexpr int also = D == Direction::reply ? row<M>.info.reply_opcode_also : -1;
            if (frame.data[f.byte] != f.fixed && frame.data[f.byte] != also)
                return false;
        } else if constexpr (f.kind == Kind::constant || f.kind == Kind::size) {
            std::int64_t value{};
            if (!get(f, frame.data.data(), value) || value != f.fixed)
                return false;
        } else if constexpr (f.kind == Kind::repeat) {
            if (frame.data[f.byte] != frame.data[f.source])
                return false;
        }
        return constants_hold<M, D, I + 1>(frame);
    }
}

template <class M, Direction D>
[[gnu::always_inline]] inline bool set_address(Frame& frame, int id, Options options)
{
    constexpr const Layout& layout = *typed_side<M, D>().layout;
    if constexpr (layout.can_base != 0) {
        frame.can_id = layout.can_base;
        if constexpr (!layout.can_fixed) {
            if (D == Direction::reply && options.can_reply_base != 0)
                frame.can_id = options.can_reply_base;
            frame.can_id += static_cast<std::uint32_t>(id);
        }
    }
    if constexpr (has<M, D>(Kind::address)) {
        constexpr Field f = first_of<M, D>(Kind::address);
        put(f, id, frame.data.data());
    }
    constexpr Range ids = id_range<M, D>();
    return layout.can_fixed || (!has<M, D>(Kind::address) && layout.can_base == 0) || ids.contains(id);
}

template <class M, Direction D>
[[gnu::always_inline]] inline int address_of(const Frame& frame, Options options)
{
    constexpr const Layout& layout = *typed_side<M, D>().layout;
    if constexpr (layout.can_base != 0 && !layout.can_fixed) {
        const bool other = D == Direction::reply && options.can_reply_base != 0;
        return static_cast<int>(frame.can_id) - static_cast<int>(other ? options.can_reply_base : layout.can_base);
    }
    if constexpr (has<M, D>(Kind::address)) {
        constexpr Field f = first_of<M, D>(Kind::address);
        std::int64_t id{};
        get(f, frame.data.data(), id);
        return static_cast<int>(id);
    }
    return -1;
}

template <class M, Direction D, std::size_t I, class Value>
[[gnu::cold]] Error explain_part(const Value& message)
{
    constexpr const auto& part = std::get<I>(typed_side<M, D>().parts);
    using Part = std::remove_cvref_t<decltype(part)>;
    if constexpr (part_field<M, D, I>.kind == Kind::sequence) {
        for (std::size_t i = 0; i < message.*part.count; ++i)
            for (const int byte : {(message.*part.member)[i].first, (message.*part.member)[i].second})
                if (byte > part.field.range.high)
                    return explain_value(row<M>.info, part.field, byte);
    } else if constexpr (!std::is_same_v<Part, Field>) {
        return explain_value(row<M>.info, part.field, static_cast<std::int64_t>(message.*part.member));
    }
    return {};
}

/// Into a blank frame; false: `explain_encoding` says why.
template <class M, Direction D, class Value, std::size_t... I>
[[gnu::always_inline]] inline bool encode(Frame& frame, int id, const Value& message, Options options,
                                          std::index_sequence<I...>)
{
    constexpr const Layout& layout = *typed_side<M, D>().layout;
    constexpr const Info& info = row<M>.info;
    if (!set_address<M, D>(frame, id, options)) [[unlikely]]
        return false;
    if constexpr (D == Direction::reply && info.reply_opcode_also >= 0)
        if (options.has(info.also_when))
            frame.data[0] = static_cast<std::uint8_t>(info.reply_opcode_also);
    if (!(put_part<M, D, I>(message, options, frame) && ...)) [[unlikely]]
        return false;
    if constexpr (has<M, D>(Kind::repeat))
        for (const Field& f : fields<M, D>)
            if (f.kind == Kind::repeat)
                frame.data[f.byte] = frame.data[f.source];
    if constexpr (layout.checksum != Checksum::none) {
        const std::size_t size = has<M, D>(Kind::sequence) ? frame.size : typed_side<M, D>().size;
        frame.data[checksum_byte(layout, size)] = checksum(layout.checksum, frame.data.data(), size);
    }
    return true;
}

template <class M, Direction D, class Value, std::size_t... I>
[[gnu::cold, gnu::noinline]] Error explain_encoding(int id, const Value& message, Options options,
                                                    std::index_sequence<I...>)
{
    Frame frame = blank<M, D>;
    if (!set_address<M, D>(frame, id, options))
        return explain_id(row<M>.info, id_range<M, D>(), id);
    Error error;
    (void)((put_part<M, D, I>(message, options, frame) || (error = explain_part<M, D, I>(message), false)) && ...);
    return error;
}

/// False: `explain_frame` says why. `Taken`: the framing of its family has found it as an answer to this message, so
/// that what its layout has a checksum for is not looked at again.
template <class M, Direction D, bool Taken = false, class Value, std::size_t... I>
[[gnu::always_inline]] inline bool decode(const Frame& frame, Options options, int& id, Value& message,
                                          std::index_sequence<I...>)
{
    constexpr const Layout& layout = *typed_side<M, D>().layout;
    constexpr std::size_t size = typed_side<M, D>().size;
    if constexpr (Taken && layout.checksum != Checksum::none && !has<M, D>(Kind::repeat))
        return (get_part<M, D, I>(frame, options, message) && ...);
    const bool size_fits =
        has<M, D>(Kind::sequence) ? frame.size >= size && frame.size <= Frame::capacity : frame.size == size;
    id = address_of<M, D>(frame, options);
    bool good = size_fits && constants_hold<M, D>(frame);
    if constexpr (layout.can_fixed)
        good = good && frame.can_id == layout.can_base;
    else if constexpr (has<M, D>(Kind::address) || layout.can_base != 0)
        good = good && id_range<M, D>().contains(id);
    if constexpr (layout.checksum != Checksum::none) {
        const std::size_t all = has<M, D>(Kind::sequence) ? frame.size : size;
        good = good && frame.data[checksum_byte(layout, all)] == checksum(layout.checksum, frame.data.data(), all);
    }
    return good && (get_part<M, D, I>(frame, options, message) && ...);
}

template <class M, Direction D>
inline constexpr auto parts =
    std::make_index_sequence<std::tuple_size_v<std::remove_cvref_t<decltype(typed_side<M, D>().parts)>>>{};

} // namespace detail

namespace detail {

template <class M, Direction D, class Value>
[[gnu::always_inline]] inline std::expected<Frame, Error> encoded(int id, const Value& message, Options options)
{
    std::expected<Frame, Error> out{std::in_place, blank<M, D>};
    if (!encode<M, D>(*out, id, message, options, parts<M, D>)) [[unlikely]]
        return std::unexpected(explain_encoding<M, D>(id, message, options, parts<M, D>));
    return out;
}

template <class M, Direction D, class Value>
[[gnu::always_inline]] inline std::expected<Addressed<Value>, Error> decoded(const Frame& frame, Options options)
{
    std::expected<Addressed<Value>, Error> out{std::in_place};
    if (!decode<M, D>(frame, options, out->id, out->message, parts<M, D>)) [[unlikely]]
        return std::unexpected(explain_frame(info_of<M>, D, frame, options));
    return out;
}

} // namespace detail

/// The bytes of a request to device `id`.
template <class M>
std::expected<Frame, Error> encode_request(int id, const M& message, Options options = {})
{
    return detail::encoded<M, Direction::request>(id, message, options);
}

template <class M>
std::expected<Addressed<M>, Error> decode_request(const Frame& frame, Options options = {})
{
    return detail::decoded<M, Direction::request, M>(frame, options);
}

/// The bytes of device `id`'s answer to an `M`.
template <class M>
std::expected<Frame, Error> encode_reply(int id, const ReplyOf<M>& message, Options options = {})
{
    return detail::encoded<M, Direction::reply>(id, message, options);
}

/// What a frame says as the answer to an `M`. The frame must be the whole answer.
template <class M>
std::expected<Addressed<ReplyOf<M>>, Error> decode_reply(const Frame& frame, Options options = {})
{
    return detail::decoded<M, Direction::reply, ReplyOf<M>>(frame, options);
}

/// Its message alone, of a frame that its family's framing has found and taken for the answer to such a request:
/// header, address and checksum are not looked at again where there is a checksum.
template <class M>
std::expected<ReplyOf<M>, Error> decode_answer(const Frame& frame, Options options = {})
{
    ReplyOf<M> reply{};
    int id = -1;
    if (!detail::decode<M, Direction::reply, true>(frame, options, id, reply, detail::parts<M, Direction::reply>))
        [[unlikely]]
        return std::unexpected(detail::explain_frame(info_of<M>, Direction::reply, frame, options));
    return std::expected<ReplyOf<M>, Error>{std::in_place, reply};
}

} // namespace sinew::wire
