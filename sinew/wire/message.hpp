#pragma once
#include "sinew/wire/row.hpp"

#include <array>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

/// How a plain struct becomes a message: beside it stands `consteval auto row_of(const Struct*)`, which returns
/// `message<Struct, Reply>(info, request side, reply side)`. `row<Struct>` is the checked row.
namespace sinew::wire {

/// A field and the member that holds its value: an integer, a bool or an enumeration.
template <class M, class T>
struct Bound {
    using Member = T;
    T M::* member;
    Field field;
};

/// Two bytes of a motion program as they travel.
struct Pair {
    std::uint8_t first{}, second{};
    friend constexpr bool operator==(const Pair&, const Pair&) = default;
};

/// Pairs at the end of a frame; `count` of them.
template <class M, std::size_t N>
struct BoundSequence {
    std::array<Pair, N> M::* member;
    std::uint8_t M::* count;
    Field field;
};

/// No request, or no reply.
struct Nothing {
    friend constexpr bool operator==(const Nothing&, const Nothing&) = default;
};

/// One direction of a message with its members.
template <class M, class... Parts>
struct TypedSide {
    using Message = M;
    const Layout* layout = nullptr;
    std::uint8_t size = 0;
    std::tuple<Parts...> parts{};
    std::string_view selector{};
    std::string_view replaced{};
    std::span<const Variant> variants{};
};

inline constexpr TypedSide<Nothing> no_side{};

template <class Request, class Reply>
struct Row {
    using RequestMessage = typename Request::Message;
    using ReplyMessage = typename Reply::Message;
    Info info;
    Request request;
    Reply reply;
};

// ---- fields with their members ----

template <class M, class T>
consteval Bound<M, T> bits(T M::* member, int msb, int lsb, Field f)
{
    f.msb = static_cast<std::uint8_t>(msb);
    f.lsb = static_cast<std::uint8_t>(lsb);
    return {member, f};
}

template <class M, class T>
consteval Bound<M, T> u8(T M::* member, Field f)
{
    return {member, f};
}

template <class M, class T>
consteval Bound<M, T> coded(T M::* member, Coding coding, int bytes, Field f)
{
    f.coding = coding;
    f.bytes = static_cast<std::uint8_t>(bytes);
    return {member, f};
}

template <class M, class T>
consteval auto i8(T M::* m, Field f)
{
    return coded(m, Coding::i_le, 1, f);
}
template <class M, class T>
consteval auto u16_le(T M::* m, Field f)
{
    return coded(m, Coding::u_le, 2, f);
}
template <class M, class T>
consteval auto i16_le(T M::* m, Field f)
{
    return coded(m, Coding::i_le, 2, f);
}
template <class M, class T>
consteval auto u32_le(T M::* m, Field f)
{
    return coded(m, Coding::u_le, 4, f);
}
template <class M, class T>
consteval auto i32_le(T M::* m, Field f)
{
    return coded(m, Coding::i_le, 4, f);
}
template <class M, class T>
consteval auto u48_le(T M::* m, Field f)
{
    return coded(m, Coding::u_le, 6, f);
}
template <class M, class T>
consteval auto i56_le(T M::* m, Field f)
{
    return coded(m, Coding::i_le, 7, f);
}
template <class M, class T>
consteval auto u16_be(T M::* m, Field f)
{
    return coded(m, Coding::u_be, 2, f);
}

/// SAM's 7-bit packing: `top_bits` in the first byte, 7 in each further one.
template <class M, class T>
consteval Bound<M, T> septets(T M::* member, int top_bits, int bytes, Field f)
{
    f.top_bits = static_cast<std::uint8_t>(top_bits);
    return coded(member, Coding::septets, bytes, f);
}

template <class M, class T>
consteval auto signed_septets(T M::* m, Field f)
{
    return coded(m, Coding::signed_septets, 2, f);
}

template <class M, std::size_t N>
consteval BoundSequence<M, N> pairs(std::array<Pair, N> M::* member, std::uint8_t M::* count, Field f)
{
    f.kind = Kind::sequence;
    f.bytes = 2;
    return {member, count, f};
}

// ---- fields without ----

consteval Field constant(std::string_view name, int byte, int value)
{
    return {.name = name, .byte = static_cast<std::uint8_t>(byte), .kind = Kind::constant, .fixed = value};
}

consteval Field constant_bits(std::string_view name, int byte, int msb, int lsb, int value)
{
    Field f = constant(name, byte, value);
    f.msb = static_cast<std::uint8_t>(msb);
    f.lsb = static_cast<std::uint8_t>(lsb);
    return f;
}

consteval Field reserved(std::string_view name, int byte, int msb = 7, int lsb = 0)
{
    Field f = constant_bits(name, byte, msb, lsb, 0);
    f.kind = Kind::reserved;
    return f;
}

consteval Field repeat(std::string_view name, int byte, int source)
{
    return {.name = name,
            .byte = static_cast<std::uint8_t>(byte),
            .kind = Kind::repeat,
            .source = static_cast<std::uint8_t>(source)};
}

// ---- rows ----

template <class M, class... Parts>
consteval TypedSide<M, Parts...> side(const Layout& layout, int size, Parts... parts)
{
    return {&layout, static_cast<std::uint8_t>(size), {parts...}};
}

/// The checked row of a message. `Request` or `Reply` is `Nothing` where there is none.
template <class Request, class Reply, class RequestSide, class ReplySide>
consteval Row<RequestSide, ReplySide> message(Info info, RequestSide request, ReplySide reply)
{
    static_assert(std::is_same_v<typename RequestSide::Message, Request>);
    static_assert(std::is_same_v<typename ReplySide::Message, Reply>);
    if (info.reply_opcode < 0)
        info.reply_opcode = info.opcode;
    return {info, request, reply};
}

template <class M>
inline constexpr auto row = row_of(static_cast<const M*>(nullptr));

template <class M>
using ReplyOf = typename std::remove_cvref_t<decltype(row<M>)>::ReplyMessage;

// ---- the same without types ----

namespace detail {

template <class Part>
constexpr Field field_of(const Part& part)
{
    if constexpr (std::is_same_v<Part, Field>)
        return part;
    else
        return part.field;
}

template <class M, Direction D>
consteval const auto& typed_side()
{
    if constexpr (D == Direction::request)
        return row<M>.request;
    else
        return row<M>.reply;
}

template <class M, Direction D>
consteval int opcode_of()
{
    return D == Direction::request ? row<M>.info.opcode : row<M>.info.reply_opcode;
}

consteval std::size_t framing_fields(const Layout* layout)
{
    return layout ? layout->fields.size() : 0;
}

template <class M, Direction D>
consteval auto collect_fields()
{
    constexpr const auto& s = typed_side<M, D>();
    constexpr std::size_t parts = std::tuple_size_v<std::remove_cvref_t<decltype(s.parts)>>;
    constexpr std::size_t framing = framing_fields(s.layout);
    std::array<Field, framing + parts> all{};
    std::size_t n = 0;
    for (std::size_t i = 0; i < framing; ++i) {
        Field f = s.layout->fields[i];
        if (f.kind == Kind::opcode)
            f.fixed = opcode_of<M, D>();
        if (f.kind == Kind::size)
            f.fixed = s.size - f.byte - 1;
        if (f.from_end)
            f.byte = static_cast<std::uint8_t>(s.size - 1);
        all[n++] = f;
    }
    std::apply([&](const auto&... part) { ((all[n++] = field_of(part)), ...); }, s.parts);
    return all;
}

/// All fields of one direction, framing first.
template <class M, Direction D>
inline constexpr auto fields = collect_fields<M, D>();

template <class M, Direction D>
consteval Side erase_side()
{
    constexpr const auto& s = typed_side<M, D>();
    constexpr const Info& info = row<M>.info;
    Side out{.layout = s.layout,
             .size = s.size,
             .fields = fields<M, D>,
             .selector = s.selector,
             .replaced = s.replaced,
             .variants = s.variants,
             .opcode = opcode_of<M, D>()};
    if (D == Direction::reply) {
        out.opcode_also = info.reply_opcode_also;
        out.also_when = info.also_when;
    }
    check_side(out);
    out.selection = selection_of(out);
    for (const Field& f : out.fields)
        if (f.kind == Kind::address || f.name == "id")
            out.device = &f;
    return out;
}

} // namespace detail

template <class M>
inline constexpr MessageInfo info_of{row<M>.info, detail::erase_side<M, Direction::request>(),
                                     detail::erase_side<M, Direction::reply>()};

/// A list of messages with unique names and opcodes, checked at compile time. Opcode -1 (none) may repeat.
template <class... Messages>
consteval std::array<const MessageInfo*, sizeof...(Messages)> catalogue()
{
    std::array<const MessageInfo*, sizeof...(Messages)> all{&info_of<Messages>...};
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            if (all[i]->info.name == all[j]->info.name)
                two_messages_have_one_name();
            if (all[i]->info.opcode >= 0 && all[i]->info.opcode == all[j]->info.opcode)
                two_messages_have_one_opcode();
        }
    return all;
}

/// A list of message types, for what must visit each of them.
template <class... Messages>
struct MessageList {
};

template <class... Messages>
consteval auto catalogue(MessageList<Messages...>)
{
    return catalogue<Messages...>();
}

} // namespace sinew::wire
