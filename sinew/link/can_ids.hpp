#pragma once
#include "sinew/base/error.hpp"

#include <cstdint>
#include <expected>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Which standard identifiers a CAN link hears, as a filter of the kernel has it. Pure.
namespace sinew::link {

/// Passes identifiers that equal `id` in the bits of `mask`.
struct IdFilter {
    std::uint32_t id = 0;
    std::uint32_t mask = 0;

    bool passes(std::uint32_t can_id) const { return (can_id & mask) == (id & mask); }
    friend bool operator==(const IdFilter&, const IdFilter&) = default;
};

/// The fewest filters that together pass a list such as `141-160,280`: identifiers in hex as candump shows them, from 0
/// to 7FF, single or from-to. `bad_uri` where it is none.
std::expected<std::vector<IdFilter>, Error> parse_can_ids(std::string_view text);

/// The link with `ids` as all that it hears, where it leads to a CAN interface of Linux and names none; any other as it
/// was.
std::string with_can_ids(const std::string& link, std::span<const std::uint32_t> ids);

} // namespace sinew::link
