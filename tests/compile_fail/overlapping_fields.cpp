// EXPECT: two_fields_claim_the_same_bit
#include "wrong_row.hpp"

namespace wrong {

consteval auto row_of(const Message*)
{
    return message<Message, Nothing>({.name = "message", .opcode = 1},
                                     side<Message>(layout, 4, u8(&Message::a, {.name = "a", .byte = 2}),
                                                   bits(&Message::b, 7, 4, {.name = "b", .byte = 2}),
                                                   reserved("rest", 3)),
                                     no_side);
}
constexpr const auto& checked = info_of<Message>;

} // namespace wrong
