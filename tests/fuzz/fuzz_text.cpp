#include "sinew/base/bytes.hpp"
#include "sinew/link/uri.hpp"
#include "tests/fuzz/check.hpp"

/// Any text as bytes in hex, as a number and as the name of a link.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    if (const auto bytes = sinew::from_hex(text)) {
        const auto again = sinew::from_hex(sinew::to_hex(*bytes));
        SINEW_CLAIM(bytes->empty() || (again && *again == *bytes));
    } else {
        SINEW_CLAIM(!to_sentence(bytes.error()).empty());
    }
    if (const auto number = sinew::to_integer(text))
        SINEW_CLAIM(sinew::to_integer(std::to_string(*number)) == *number);
    if (const auto uri = sinew::link::parse_uri(text)) {
        const auto again = sinew::link::parse_uri(to_string(*uri));
        SINEW_CLAIM(again.has_value());
        SINEW_CLAIM(again->scheme == uri->scheme && again->target == uri->target);
        SINEW_CLAIM(again->fragment == uri->fragment && again->options == uri->options);
    } else {
        SINEW_CLAIM(!to_sentence(uri.error()).empty());
    }
    return 0;
}
