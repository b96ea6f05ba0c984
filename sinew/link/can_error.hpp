#pragma once
#include "sinew/wire/frame.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace sinew::link {

/// What a CAN controller says of its bus in an error frame of Linux, word by word: `bus-off`, `error-passive-sending`,
/// `no-acknowledgement` and so on, in the order of the classes. `can_id` of the frame has the classes, without the flag
/// 0x20000000. What this does not know is `class-0x…`. Source: linux/can/error.h.
std::vector<std::string> can_error_words(const wire::Frame& error);

/// The same in one sentence, with the controller's error counters where the frame has them.
std::string can_error_sentence(const wire::Frame& error);

} // namespace sinew::link
