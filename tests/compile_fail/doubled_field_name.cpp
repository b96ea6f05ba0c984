// EXPECT: two_fields_have_one_name
#include "wrong_row.hpp"

namespace wrong {

consteval auto row_of(const Message*)
{
    return message<Message, Nothing>(
        {.name = "message", .opcode = 1},
        side<Message>(layout, 4, u8(&Message::a, {.name = "a", .byte = 2}), u8(&Message::b, {.name = "a", .byte = 3})),
        no_side);
}
constexpr const auto& checked = info_of<Message>;

} // namespace wrong
