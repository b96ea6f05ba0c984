#pragma once
#include "sinew/diagnosis/audience.hpp"
#include "sinew/wire/protocol.hpp"

#include <optional>

namespace sinew::diagnosis {

/// The ways to ask a device whether it is there, the best first: its family's own probe, the same with other bytes
/// where the device looks at none, and other reads that every device answers.
std::vector<wire::Request> ways_to_ask(const Family& family, int id);
/// The ways to ask a SAM for its model. Their answer does not name the device. The last resort is another byte before
/// the frame.
std::vector<wire::Request> ways_to_ask_model(const Family& family, int id);

/// The ways to send any read, the plain one first.
std::vector<wire::Request> ways_to_send(const Family& family, const wire::Request& read);

/// Single bytes that are nothing to a device at the rate at which they are sent.
std::span<const std::uint8_t> fillers();

/// The first of them that harms nobody who hears it at another bit rate; nothing when there is none.
std::optional<wire::Request> safe_one(std::span<const wire::Request> ways, const Audience& audience,
                                      std::uint32_t bit_rate);

} // namespace sinew::diagnosis
