#pragma once
#include "sinew/wire/protocol.hpp"
#include "tests/fuzz/check.hpp"

#include <algorithm>
#include <span>
#include <vector>

/// What holds for every framing, whatever the bytes are.
namespace sinew::fuzz {

using Find = wire::Scan (*)(std::span<const std::uint8_t> bytes, bool silent);

/// The frames of a stream that arrives in pieces of `piece` bytes and then ends in silence.
inline std::vector<std::vector<std::uint8_t>> frames_of(std::span<const std::uint8_t> stream, std::size_t piece,
                                                        Find find)
{
    std::vector<std::vector<std::uint8_t>> out;
    std::vector<std::uint8_t> waiting;
    const auto scan = [&](bool silent) {
        for (;;) {
            const wire::Scan next = find(waiting, silent);
            SINEW_CLAIM(next.skip <= waiting.size());
            SINEW_CLAIM(next.size <= waiting.size() - next.skip);
            SINEW_CLAIM(next.size <= wire::Frame::capacity);
            const auto begin = waiting.begin() + static_cast<std::ptrdiff_t>(next.skip);
            const auto end = begin + static_cast<std::ptrdiff_t>(next.size);
            if (next.size != 0)
                out.emplace_back(begin, end);
            waiting.erase(waiting.begin(), end);
            if (next.size == 0)
                break;
        }
        SINEW_CLAIM(!silent || waiting.empty());
        SINEW_CLAIM(waiting.size() < wire::Frame::capacity);
    };
    for (std::size_t at = 0; at < stream.size(); at += piece) {
        const auto bytes = stream.subspan(at, std::min(piece, stream.size() - at));
        waiting.insert(waiting.end(), bytes.begin(), bytes.end());
        scan(false);
    }
    scan(true);
    return out;
}

/// The first byte says how long the pieces are; any other cut gives the same frames, and each is one when it comes
/// alone.
inline void claim_framing(std::span<const std::uint8_t> input, Find find)
{
    if (input.empty())
        return;
    const std::size_t piece = 1 + input.front() % 16U;
    const auto stream = input.subspan(1);
    const auto frames = frames_of(stream, piece, find);
    SINEW_CLAIM(frames == frames_of(stream, std::max<std::size_t>(stream.size(), 1), find));
    for (const auto& frame : frames) {
        const wire::Scan alone = find(frame, false);
        SINEW_CLAIM(alone.skip == 0 && alone.size == frame.size());
    }
}

} // namespace sinew::fuzz
