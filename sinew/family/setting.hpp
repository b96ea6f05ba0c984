#pragma once
#include <cstdint>
#include <string_view>

namespace sinew {

/// Something that a device keeps and tells: a message that reads it beside the one that writes it. Messages by name, so
/// that one list serves every firmware line; a line has the setting where it lists both. The fields of the request that
/// writes stand under the same names in the answer of the read.
struct SettingInfo {
    std::string_view name;
    std::string_view read;
    std::string_view write;
    /// Sets it until power-off; empty: `write` is the only way.
    std::string_view trial{};
    /// Of settings that share their messages: what the first field of both requests must be. -1: none.
    std::int64_t selected = -1;
    /// Belongs to this one device, its mounting or its encoder, and is wrong in any other.
    bool calibration = false;
    /// Decides whether the device answers at all: one that does not can be set all the same, but not asked.
    bool decides_answers = false;
};

/// How a device is told that it stands at its zero. The line has it where it lists the message; the first that fits is
/// taken.
struct ZeroInfo {
    std::string_view message;
    std::string_view field{}; ///< the only one that the request has; empty: none
    std::int64_t raw = 0;
    std::int64_t undo = -1;  ///< takes it back; -1: that cannot be done
    std::string_view says{}; ///< how long it holds, and what else must be known
};

/// A gain of the position loop as people call it, and where it is.
struct GainInfo {
    std::string_view name; ///< "p"
    std::string_view setting;
    std::string_view field;
};

} // namespace sinew
