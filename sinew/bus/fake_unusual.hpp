#pragma once
#include "sinew/bus/fake_family.hpp"

/// Messages of the fake family that few tests need: whose answers look like those of others, for all motors at once,
/// and commands that may never be sent twice.
namespace sinew::bus::fake {

struct ReadToo {
};
consteval auto row_of(const ReadToo*)
{
    return message<ReadToo, Number>({.name = "read-too", .opcode = 9, .reply_opcode = 1},
                                    side<ReadToo>(framed, 4, reserved("free", 3)),
                                    side<Number>(framed, 4, u8(&Number::value, {.name = "value", .byte = 3})));
}

struct ReadMore {
};
consteval auto row_of(const ReadMore*)
{
    return message<ReadMore, Number>(
        {.name = "read-more", .opcode = 8, .reply_opcode = 1}, side<ReadMore>(framed, 4, reserved("free", 3)),
        side<Number>(framed, 5, u8(&Number::value, {.name = "value", .byte = 3}), reserved("more", 4)));
}

inline constexpr Layout all_motors{.name = "all", .fields = can_fields, .can_base = 0x80, .can_fixed = true};
struct ReadAll {
};
consteval auto row_of(const ReadAll*)
{
    return message<ReadAll, Number>({.name = "read-all", .opcode = 5},
                                    side<ReadAll>(all_motors, 2, reserved("free", 1)),
                                    side<Number>(can, 2, u8(&Number::value, {.name = "value", .byte = 1})));
}

struct Push {
};
consteval auto row_of(const Push*)
{
    return message<Push, Number>({.name = "push", .opcode = 10, .access = Access::command, .relative = true},
                                 side<Push>(framed, 4, reserved("free", 3)),
                                 side<Number>(framed, 4, u8(&Number::value, {.name = "value", .byte = 3})));
}

struct Store {
};
consteval auto row_of(const Store*)
{
    return message<Store, Number>({.name = "store", .opcode = 11, .access = Access::flash},
                                  side<Store>(framed, 4, reserved("free", 3)),
                                  side<Number>(framed, 4, u8(&Number::value, {.name = "value", .byte = 3})));
}

} // namespace sinew::bus::fake
