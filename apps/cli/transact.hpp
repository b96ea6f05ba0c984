#pragma once
#include "apps/cli/session.hpp"

namespace sinew::cli {

/// Sends one message to a device and shows request and answer: the common part of `get`, `set` and `send`. With
/// `--dry-run` nothing is opened. Asks first where the message moves something or writes flash, which is counted.
/// `spare_flash`: a setting that the device can be asked for is read first, and not written where it is so already.
Outcome transact(const Words& words, Device device, const wire::MessageInfo& message,
                 std::span<const std::string> field_words, bool spare_flash = false);

} // namespace sinew::cli
