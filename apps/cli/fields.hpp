#pragma once
#include "apps/cli/device.hpp"

namespace sinew::cli {

/// The values of a request from words such as `id=3`, `direction=CW`, `speed=0x10`, `position=90deg` (rounded to what
/// the wire carries) and, for sequences, `instructions=1,20,2,40`. Everything that `wire::encode` needs is there, or it
/// is an error with the field's name: `unknown_name`, `missing_field`, `bad_argument`, `out_of_range`.
std::expected<wire::Values, Error> values_from(const Device& device, const wire::MessageInfo& message,
                                               std::span<const std::string> words);

/// The request of a message with fields as they are written on the command line, such as "new_id=9".
std::expected<wire::Request, Error> request_from(const Device& device, const wire::MessageInfo& message,
                                                 std::span<const std::string> words);

} // namespace sinew::cli
