#pragma once
#include "sinew/record/captured.hpp"
#include "tests/fuzz/check.hpp"

#include <algorithm>

namespace sinew::fuzz {

/// Everything that a reader finds in `bytes`, fed in pieces of the size that the first byte says.
template <class Reader, class Use>
void read_recording(std::span<const std::uint8_t> bytes, Use&& use)
{
    if (bytes.empty())
        return;
    const std::size_t piece = std::size_t{1} + bytes[0];
    bytes = bytes.subspan(1);
    Reader reader;
    // Every byte can be at most one error or frame, and so can the end.
    std::size_t left = bytes.size() + 2;
    const auto drain = [&] {
        for (;;) {
            const auto one = reader.next();
            if (one && !*one)
                return;
            SINEW_CLAIM(left-- > 0);
            if (one)
                use(**one);
            else
                claim_explained(one.error());
        }
    };
    while (!bytes.empty()) {
        const auto part = bytes.first(std::min(piece, bytes.size()));
        reader.feed(part);
        drain();
        bytes = bytes.subspan(part.size());
    }
    reader.end();
    drain();
}

/// The only frame that a reader finds in what a writer wrote.
template <class Reader, class Writer>
std::optional<record::Captured> written_and_read(const record::Captured& captured)
{
    Writer writer;
    std::string text;
    if (!writer.add(captured, text)) {
        SINEW_CLAIM(text.empty());
        return std::nullopt;
    }
    Reader reader;
    reader.feed({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    reader.end();
    const auto again = reader.next();
    SINEW_CLAIM(again && *again);
    const auto none = reader.next();
    SINEW_CLAIM(none && !*none);
    return **again;
}

} // namespace sinew::fuzz
