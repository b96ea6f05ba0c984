#include "sinew/link/slcan_codec.hpp"

#include <algorithm>
#include <utility>

namespace sinew::link::slcan {
namespace {

constexpr std::size_t most_data = 8;
constexpr std::uint32_t highest_id = 0x7FF;
constexpr std::uint32_t highest_extended_id = 0x1FFF'FFFF;
constexpr std::size_t time_stamp_digits = 4;

char to_digit(std::uint32_t value)
{
    return "0123456789ABCDEF"[value & 0xF];
}

std::optional<std::uint32_t> from_digits(std::string_view text)
{
    std::uint32_t value = 0;
    for (const char c : text) {
        if (c >= '0' && c <= '9')
            value = value * 16 + static_cast<std::uint32_t>(c - '0');
        else if (c >= 'A' && c <= 'F')
            value = value * 16 + static_cast<std::uint32_t>(c - 'A' + 10);
        else if (c >= 'a' && c <= 'f')
            value = value * 16 + static_cast<std::uint32_t>(c - 'a' + 10);
        else
            return std::nullopt;
    }
    return value;
}

} // namespace

std::optional<char> code_of(std::uint32_t bit_rate)
{
    const auto found = std::ranges::find(bit_rates, bit_rate);
    if (found == bit_rates.end())
        return std::nullopt;
    return static_cast<char>('0' + (found - bit_rates.begin()));
}

std::size_t encode(const wire::Frame& frame, std::span<std::uint8_t, longest_frame_text> into)
{
    if (frame.size > most_data || frame.can_id > highest_id)
        return 0;
    std::size_t size = 0;
    const auto put = [&](char c) { into[size++] = static_cast<std::uint8_t>(c); };
    put('t');
    for (const int shift : {8, 4, 0})
        put(to_digit(frame.can_id >> shift));
    put(to_digit(frame.size));
    for (const std::uint8_t byte : frame.bytes()) {
        put(to_digit(byte >> 4u));
        put(to_digit(byte));
    }
    put(end_of_line);
    return size;
}

Line decode(std::string_view text)
{
    const char letter = text.empty() ? '\0' : text.front();
    if (letter != 't' && letter != 'T' && letter != 'r' && letter != 'R')
        return {.kind = Kind::other};
    const bool is_extended = letter == 'T' || letter == 'R';
    const bool is_remote = letter == 'r' || letter == 'R';
    const std::size_t id_digits = is_extended ? 8 : 3;
    constexpr Line malformed{.kind = Kind::malformed};
    if (text.size() < 1 + id_digits + 1)
        return malformed;

    const auto id = from_digits(text.substr(1, id_digits));
    const auto size = from_digits(text.substr(1 + id_digits, 1));
    if (!id || !size || *id > (is_extended ? highest_extended_id : highest_id) || *size > most_data)
        return malformed;
    const std::string_view data = text.substr(1 + id_digits + 1);
    const std::size_t data_digits = is_remote ? 0 : *size * 2;
    if (data.size() != data_digits && data.size() != data_digits + time_stamp_digits)
        return malformed;
    if (!from_digits(data.substr(data_digits)))
        return malformed;

    Line line{.kind = is_extended || is_remote ? Kind::foreign : Kind::frame};
    line.frame.can_id = *id;
    line.frame.size = static_cast<std::uint8_t>(*size);
    for (std::size_t i = 0; i < data_digits / 2; ++i) {
        const auto byte = from_digits(data.substr(2 * i, 2));
        if (!byte)
            return malformed;
        line.frame.data[i] = static_cast<std::uint8_t>(*byte);
    }
    return line;
}

std::optional<std::uint8_t> decode_flags(std::string_view text)
{
    if (text.size() != 3 || text.front() != 'F')
        return std::nullopt;
    const auto flags = from_digits(text.substr(1));
    return flags ? std::optional(static_cast<std::uint8_t>(*flags)) : std::nullopt;
}

std::string to_words(std::uint8_t flags)
{
    constexpr std::pair<std::uint8_t, std::string_view> words[] = {{flag::bus_error, "bus error"},
                                                                   {flag::error_passive, "error passive"},
                                                                   {flag::error_warning, "error warning"},
                                                                   {flag::arbitration_lost, "arbitration lost"},
                                                                   {flag::overrun, "overrun"},
                                                                   {flag::receive_queue_full, "receive queue full"},
                                                                   {flag::transmit_queue_full, "transmit queue full"}};
    std::string out;
    for (const auto& [bit, word] : words) {
        if ((flags & bit) == 0)
            continue;
        if (!out.empty())
            out += ", ";
        out += word;
    }
    return out;
}

Reader::End Reader::take(std::uint8_t byte)
{
    if (ended_) {
        size_ = 0;
        ended_ = overlong_ = false;
    }
    const char c = static_cast<char>(byte);
    if (c == end_of_line || c == bell) {
        ended_ = true;
        if (overlong_) {
            size_ = 0;
            return End::overlong;
        }
        return c == bell ? End::refused : End::line;
    }
    if (c == '\n') // some adapters end their lines with CR LF
        return End::none;
    if (size_ == capacity)
        overlong_ = true;
    else
        text_[size_++] = c;
    return End::none;
}

} // namespace sinew::link::slcan
