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
consteval Range id_range()
{
    for (const Field& f : fields<M, D>)
        if (f.kind == Kind::address)
            return allowed(f);
    return typed_side<M, D>().layout->ids;
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
        for (const Field& f : fields<M, D>)
            if (f.kind == Kind::address)
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
    for (const Field& f : fields<M, D>)
        if (f.kind == Kind::address) {
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

template <class M, Direction D, class Value, std::size_t... I>
[[gnu::always_inline]] inline std::expected<Frame, Error> encode(int id, const Value& message, Options options,
                                                                 std::index_sequence<I...>)
{
    constexpr const Layout& layout = *typed_side<M, D>().layout;
    constexpr const Info& info = row<M>.info;
    std::expected<Frame, Error> out{std::in_place, blank<M, D>};
    Frame& frame = *out;
    if (!set_address<M, D>(frame, id, options)) [[unlikely]]
        return std::unexpected(explain_id(info, id_range<M, D>(), id));
    if constexpr (D == Direction::reply && info.reply_opcode_also >= 0)
        if (options.has(info.also_when))
            frame.data[0] = static_cast<std::uint8_t>(info.reply_opcode_also);
    std::size_t bad = sizeof...(I);
    (void)((put_part<M, D, I>(message, options, frame) || (bad = I, false)) && ...);
    if (bad != sizeof...(I)) [[unlikely]] {
        Error error;
        (void)((I == bad && (error = explain_part<M, D, I>(message), true)) || ...);
        return std::unexpected(std::move(error));
    }
    for (const Field& f : fields<M, D>)
        if (f.kind == Kind::repeat)
            frame.data[f.byte] = frame.data[f.source];
    if constexpr (layout.checksum != Checksum::none)
        frame.data[checksum_byte(layout, frame.size)] = checksum(layout.checksum, frame.data.data(), frame.size);
    return out;
}

template <class M, Direction D, class Value, std::size_t... I>
[[gnu::always_inline]] inline std::expected<Addressed<Value>, Error> decode(const Frame& frame, Options options,
                                                                            std::index_sequence<I...>)
{
    constexpr const Layout& layout = *typed_side<M, D>().layout;
    constexpr std::size_t size = typed_side<M, D>().size;
    std::expected<Addressed<Value>, Error> out{std::in_place};
    const bool size_fits =
        has<M, D>(Kind::sequence) ? frame.size >= size && frame.size <= Frame::capacity : frame.size == size;
    out->id = address_of<M, D>(frame, options);
    bool good = size_fits && constants_hold<M, D>(frame);
    if constexpr (layout.can_fixed)
        good = good && frame.can_id == layout.can_base;
    else if constexpr (has<M, D>(Kind::address) || layout.can_base != 0)
        good = good && id_range<M, D>().contains(out->id);
    if constexpr (layout.checksum != Checksum::none)
        good = good && frame.data[checksum_byte(layout, frame.size)] ==
                           checksum(layout.checksum, frame.data.data(), frame.size);
    good = good && (get_part<M, D, I>(frame, options, out->message) && ...);
    if (!good) [[unlikely]]
        return std::unexpected(explain_frame(info_of<M>, D, frame, options));
    return out;
}

template <class M, Direction D>
inline constexpr auto parts =
    std::make_index_sequence<std::tuple_size_v<std::remove_cvref_t<decltype(typed_side<M, D>().parts)>>>{};

} // namespace detail

/// The bytes of a request to device `id`.
template <class M>
std::expected<Frame, Error> encode_request(int id, const M& message, Options options = {})
{
    return detail::encode<M, Direction::request>(id, message, options, detail::parts<M, Direction::request>);
}

template <class M>
std::expected<Addressed<M>, Error> decode_request(const Frame& frame, Options options = {})
{
    return detail::decode<M, Direction::request, M>(frame, options, detail::parts<M, Direction::request>);
}

/// The bytes of device `id`'s answer to an `M`.
template <class M>
std::expected<Frame, Error> encode_reply(int id, const ReplyOf<M>& message, Options options = {})
{
    return detail::encode<M, Direction::reply>(id, message, options, detail::parts<M, Direction::reply>);
}

/// What a frame says as the answer to an `M`. The frame must be the whole answer.
template <class M>
std::expected<Addressed<ReplyOf<M>>, Error> decode_reply(const Frame& frame, Options options = {})
{
    return detail::decode<M, Direction::reply, ReplyOf<M>>(frame, options, detail::parts<M, Direction::reply>);
}

} // namespace sinew::wire
