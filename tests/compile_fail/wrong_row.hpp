#pragma once
#include "sinew/wire/message.hpp"

/// A small family of which each case breaks one thing: frames of four bytes, `opcode id value value`.
namespace wrong {

using namespace sinew::wire;

inline constexpr Field fields[] = {{.name = "opcode", .byte = 0, .kind = Kind::opcode},
                                   {.name = "id", .byte = 1, .kind = Kind::address, .range = {0, 9}}};
inline constexpr Layout layout{.name = "wrong", .fields = fields, .ids = {0, 9}};

struct Message {
    std::uint8_t a{}, b{};
};

} // namespace wrong
