// EXPECT: two_messages_have_one_name
#include "wrong_row.hpp"

namespace wrong {

consteval auto row_of(const Message*)
{
    return message<Message, Nothing>(
        {.name = "message", .opcode = 1},
        side<Message>(layout, 4, u8(&Message::a, {.name = "a", .byte = 2}), u8(&Message::b, {.name = "b", .byte = 3})),
        no_side);
}

struct Other {
    std::uint8_t a{}, b{};
};

consteval auto row_of(const Other*)
{
    return message<Other, Nothing>(
        {.name = "message", .opcode = 2},
        side<Other>(layout, 4, u8(&Other::a, {.name = "a", .byte = 2}), u8(&Other::b, {.name = "b", .byte = 3})),
        no_side);
}

constexpr auto all = catalogue<Message, Other>();

} // namespace wrong
