#pragma once
#include "sinew/base/error.hpp"
#include "sinew/wire/frame.hpp"

#include <expected>
#include <span>

namespace sinew::link {

/// Refuses what no classic CAN frame with a standard identifier can be: `bad_length` for more than 8 bytes,
/// `out_of_range` for an identifier above 0x7FF.
inline std::expected<void, Error> check_can_frames(std::span<const wire::Frame> frames)
{
    for (const wire::Frame& frame : frames) {
        if (frame.size > 8)
            return std::unexpected(Error{.code = Errc::bad_length, .value = frame.size, .low = 8});
        if (frame.can_id > 0x7FF)
            return std::unexpected(Error{
                .code = Errc::out_of_range, .field = "CAN identifier", .value = frame.can_id, .low = 0, .high = 0x7FF});
    }
    return {};
}

} // namespace sinew::link
