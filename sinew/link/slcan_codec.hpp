#pragma once
#include "sinew/wire/frame.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// The text protocol of serial CAN adapters, for both of its ends: lines that end with CR, or with BEL where the
/// adapter refuses. Pure: no I/O, no clock, no heap. Source: LAWICEL CANUSB manual, chapter "Commands", and
/// python-can's and Linux' slcan, which agree with it on everything that is used here.
namespace sinew::link::slcan {

inline constexpr char end_of_line = '\r';
inline constexpr char bell = '\a';

/// The bit rates of the commands S0 … S8, in bits per second. (python-can calls S7 750 kbit/s; the manual says 800.)
inline constexpr std::array<std::uint32_t, 9> bit_rates = {10'000,  20'000,  50'000,  100'000,  125'000,
                                                           250'000, 500'000, 800'000, 1'000'000};

/// The digit after S, or nothing for a rate that the protocol has no code for.
std::optional<char> code_of(std::uint32_t bit_rate);

/// "t1A32FF00\r", the longest: eight bytes of data.
inline constexpr std::size_t longest_frame_text = 1 + 3 + 1 + 16 + 1;
/// Of a frame with so many bytes.
constexpr std::size_t frame_text_size(std::size_t bytes)
{
    return 1 + 3 + 1 + 2 * bytes + 1;
}
static_assert(frame_text_size(8) == longest_frame_text);

/// A data frame with an 11-bit identifier as text with its CR. Nothing is written and 0 returned where the frame is
/// none of CAN: more than 8 bytes or an identifier above 0x7FF.
std::size_t encode(const wire::Frame& frame, std::span<std::uint8_t, longest_frame_text> into);

/// What a line is, for the end that reads it.
enum class Kind : std::uint8_t {
    frame,    ///< a data frame with an 11-bit identifier: `frame` holds it
    foreign,  ///< a sound frame that no device of this library speaks: extended identifier or remote request
    other,    ///< anything that is no frame: an acknowledgement, an answer, a command
    malformed ///< begins like a frame and is none: wrong length, a character that is no hex digit
};

struct Line {
    Kind kind = Kind::other;
    wire::Frame frame{};
};

/// `text` without its end. The four digits of a time stamp after the data are allowed and dropped.
Line decode(std::string_view text);

/// What an adapter answers to F, and forgets by it. Source: LAWICEL CANUSB manual, "F[CR]".
namespace flag {
inline constexpr std::uint8_t receive_queue_full = 0x01; ///< frames were lost: the host does not fetch them
inline constexpr std::uint8_t transmit_queue_full = 0x02;
inline constexpr std::uint8_t error_warning = 0x04;
inline constexpr std::uint8_t overrun = 0x08; ///< frames were lost in the controller
inline constexpr std::uint8_t error_passive = 0x20;
inline constexpr std::uint8_t arbitration_lost = 0x40;
inline constexpr std::uint8_t bus_error = 0x80;
} // namespace flag

/// The flags in a line such as "F84"; nothing where it is no such line.
std::optional<std::uint8_t> decode_flags(std::string_view text);

/// "bus error, error passive"; empty: none.
std::string to_words(std::uint8_t flags);

/// Cuts a stream into lines, however it is split. A line that is too long to be one is swallowed to its end.
class Reader
{
public:
    enum class End : std::uint8_t {
        none,    ///< the line goes on
        line,    ///< CR: `text()` is whole until the next byte
        refused, ///< BEL: so is `text()`, mostly empty
        overlong ///< too long: `text()` is empty
    };
    End take(std::uint8_t byte);
    std::string_view text() const { return {text_.data(), size_}; }

private:
    static constexpr std::size_t capacity = 32; ///< T + 8 + 1 + 16 + 4 digits of time stamp, and a little air
    std::array<char, capacity> text_{};
    std::size_t size_ = 0;
    bool overlong_ = false;
    bool ended_ = false;
};

} // namespace sinew::link::slcan
