#pragma once
#include "sinew/base/time.hpp"
#include "sinew/wire/row.hpp"

#include <cstdint>
#include <span>
#include <string_view>

namespace sinew::bus {

/// What became of a frame, or why it was discarded.
enum class Verdict : std::uint8_t {
    sent,         ///< a request, handed to the link
    taken,        ///< the answer to a request
    stray,        ///< belongs to nothing that was asked
    late,         ///< an answer that nobody waits for any more
    bad_checksum, ///< bytes with a frame in them whose checksum does not fit
    echo,         ///< the own request
    quarantined,  ///< came while the line was not trusted
};

std::string_view to_word(Verdict verdict);

/// What passed, as the tap shows it: one frame, or on serial lines a run of bytes that make up none.
struct Tapped {
    TimePoint at{}; ///< when it was handed to the link, or when its end had arrived
    wire::Direction direction{};
    std::span<const std::uint8_t> bytes; ///< valid during the call
    std::uint32_t can_id = 0;
    Verdict verdict = Verdict::sent;
};

} // namespace sinew::bus
