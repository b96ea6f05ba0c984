// EXPECT: a_byte_is_not_explained
#include "wrong_row.hpp"

namespace wrong {

consteval auto row_of(const Message*)
{
    return message<Message, Nothing>({.name = "message", .opcode = 1},
                                     side<Message>(layout, 4, u8(&Message::a, {.name = "a", .byte = 2})), no_side);
}
constexpr const auto& checked = info_of<Message>;

} // namespace wrong
