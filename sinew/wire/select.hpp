#pragma once
#include "sinew/wire/frame.hpp"
#include "sinew/wire/row.hpp"

namespace sinew::wire {

namespace detail {

[[gnu::cold, gnu::noinline]] inline bool selects_by_fields(const Side& side, const Frame& frame)
{
    bool grows = false;
    for (const auto& f : side.fields)
        grows = grows || f.kind == Kind::sequence;
    if (grows ? frame.size < side.size : frame.size != side.size)
        return false;
    for (const auto& f : side.fields) {
        if (f.kind == Kind::opcode && frame.data[f.byte] != f.fixed && frame.data[f.byte] != side.opcode_also)
            return false;
        std::int64_t value{};
        if ((f.kind == Kind::constant || f.kind == Kind::size) &&
            (!get(f, frame.data.data(), value) || value != f.fixed))
            return false;
    }
    return true;
}

} // namespace detail

/// Whether the constants and the opcode of a side stand in the frame and its size fits: the bytes that say which
/// message it is, without its values and its checksum.
inline bool selects(const Side& side, const Frame& frame)
{
    const Selection& by = side.selection;
    if (by.is_all) [[likely]]
        return frame.size == side.size && (frame.first_eight() & by.mask) == by.value;
    return detail::selects_by_fields(side, frame);
}

/// A named field of a side, or nullptr.
inline const Field* find_field(const Side& side, std::string_view name)
{
    for (const auto& f : side.fields)
        if (f.name == name)
            return &f;
    return nullptr;
}

} // namespace sinew::wire
