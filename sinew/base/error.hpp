#pragma once
#include "sinew/base/time.hpp"

#include <array>
#include <cstdint>
#include <expected>
#include <span>
#include <string>
#include <string_view>

namespace sinew {

/// What went wrong, grouped by who can act on it.
enum class Errc : std::uint8_t {
    // the caller gave something that cannot be done; nothing was sent
    bad_argument,   ///< a word, option or combination that makes no sense; `detail` says what to write instead
    out_of_range,   ///< a value outside the range of its field; `field`, `value`, `low`, `high`
    unknown_name,   ///< no message, field, family … of that name; `detail` holds the nearest one
    missing_field,  ///< a field of the message was not given
    bad_id,         ///< an id that the family cannot address
    bad_hex,        ///< text that is not bytes in hex
    not_in_profile, ///< the message does not exist on this firmware line, so it is refused
    unsupported,    ///< the device cannot do this
    bad_file,       ///< a file that cannot be used; `detail` carries file, line and column
    bad_uri,        ///< a link that cannot be understood
    // the port
    link_not_found, ///< no such device file, host or simulated bus
    link_denied,    ///< not permitted
    link_busy,      ///< held by another program
    link_lost,      ///< was open and hung up
    link_failed,    ///< the operating system refused for another reason; `detail` has its words
    // the wire
    timeout,      ///< no answer within `elapsed`
    bad_length,   ///< a frame of the wrong length
    bad_constant, ///< a byte that must have one value and has another
    bad_checksum, ///< a checksum that does not fit
    bad_repeat,   ///< a value that is sent twice, and differs
    bad_reply,    ///< an answer that does not belong to the request
    // the way out
    stopped, ///< ended by stop() before it was done
};

/// One failure with its evidence. Copying is cheap and allocates nothing unless `detail` is used, which the hot path
/// never does. The string views point at names of rows, which live as long as the program.
struct Error {
    Errc code{};
    std::string_view message{}; ///< name of the message on the wire
    std::string_view field{};
    std::int64_t value{}, low{}, high{};
    int id{-1}; ///< address of the device, -1: none
    std::uint8_t seen_size{};
    std::array<std::uint8_t, 16> seen{}; ///< the first bytes that were seen instead
    Duration elapsed{};
    std::string detail{};
};

/// Keeps the first bytes of `bytes` in the error as evidence.
void keep_seen(Error& error, std::span<const std::uint8_t> bytes);

/// One sentence that a person can act on, without a final newline.
std::string to_sentence(const Error& error);

/// The stable word of a code for JSON and logs, such as "out_of_range".
std::string_view to_word(Errc code);

/// An error that is all words: a code and what to say.
inline std::unexpected<Error> fail(Errc code, std::string detail)
{
    Error error{.code = code};
    error.detail = std::move(detail);
    return std::unexpected(std::move(error));
}

} // namespace sinew
