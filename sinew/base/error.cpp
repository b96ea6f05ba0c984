#include "sinew/base/error.hpp"

#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew {
namespace {

struct Word {
    Errc code;
    std::string_view word;
};

constexpr Word words[] = {
    {Errc::bad_argument, "bad_argument"},
    {Errc::out_of_range, "out_of_range"},
    {Errc::unknown_name, "unknown_name"},
    {Errc::missing_field, "missing_field"},
    {Errc::bad_id, "bad_id"},
    {Errc::bad_hex, "bad_hex"},
    {Errc::not_in_profile, "not_in_profile"},
    {Errc::unsupported, "unsupported"},
    {Errc::bad_file, "bad_file"},
    {Errc::bad_uri, "bad_uri"},
    {Errc::link_not_found, "link_not_found"},
    {Errc::link_denied, "link_denied"},
    {Errc::link_busy, "link_busy"},
    {Errc::link_lost, "link_lost"},
    {Errc::link_failed, "link_failed"},
    {Errc::timeout, "timeout"},
    {Errc::bad_length, "bad_length"},
    {Errc::bad_constant, "bad_constant"},
    {Errc::bad_checksum, "bad_checksum"},
    {Errc::bad_repeat, "bad_repeat"},
    {Errc::bad_reply, "bad_reply"},
    {Errc::stopped, "stopped"},
};

std::string where(const Error& e)
{
    std::string text;
    if (!e.message.empty())
        text = e.message;
    if (e.id >= 0)
        text += fmt::format("{}id {}", text.empty() ? "" : " to ", e.id);
    return text.empty() ? text : text + ": ";
}

std::string seen(const Error& e)
{
    return e.seen_size ? fmt::format(" (seen: {})", to_hex(std::span(e.seen).first(e.seen_size))) : std::string{};
}

std::string what(const Error& e)
{
    switch (e.code) {
    case Errc::out_of_range:
        return fmt::format("{} is {}, which is outside {} … {}", e.field, e.value, e.low, e.high);
    case Errc::missing_field:
        return fmt::format("{} was not given", e.field);
    case Errc::timeout:
        return fmt::format("no answer within {:.1f} ms; is the device powered, and are id, bit rate and wiring right?",
                           seconds(e.elapsed) * 1e3);
    case Errc::bad_length:
        return fmt::format("{} bytes where {} were expected", e.value, e.low);
    case Errc::bad_constant:
        return fmt::format("{} is 0x{:02X} where 0x{:02X} must stand", e.field, e.value, e.low);
    case Errc::bad_checksum:
        return fmt::format("checksum 0x{:02X}, expected 0x{:02X}", e.value, e.low);
    case Errc::bad_repeat:
        return fmt::format("{} is sent twice and differs: {} and {}", e.field, e.low, e.value);
    case Errc::bad_id:
        return fmt::format("id {} is outside {} … {}", e.value, e.low, e.high);
    case Errc::stopped:
        return "stopped before it was done";
    case Errc::bad_reply:
        return "the answer does not belong to the request";
    case Errc::not_in_profile:
        return "the message does not exist on this firmware line, so it is not sent";
    default:
        return std::string{to_word(e.code)};
    }
}

} // namespace

void keep_seen(Error& error, std::span<const std::uint8_t> bytes)
{
    error.seen_size = static_cast<std::uint8_t>(std::min(bytes.size(), error.seen.size()));
    std::ranges::copy(bytes.first(error.seen_size), error.seen.begin());
}

std::string to_sentence(const Error& error)
{
    // Words that were chosen where the error arose say more than anything that can be made from the numbers.
    const std::string said = error.detail.empty() ? what(error) : error.detail;
    return where(error) + said + seen(error);
}

std::string_view to_word(Errc code)
{
    for (const auto& row : words)
        if (row.code == code)
            return row.word;
    return "unknown";
}

} // namespace sinew
