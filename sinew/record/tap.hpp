#pragma once
#include "sinew/bus/bus.hpp"
#include "sinew/record/captured.hpp"

namespace sinew::record {

/// What the tap of a bus shows, as a value. `zero` is the time of day at which the clock of the bus stood at zero:
/// `time_of_day_zero` for a real one, the default for a virtual one.
inline Captured captured_from(const bus::Tapped& tapped, std::string_view bus, std::string_view family, bool can,
                              Time zero = {})
{
    Captured out{.at = zero + tapped.at.time_since_epoch(),
                 .bus = std::string(bus),
                 .family = std::string(family),
                 .direction = tapped.direction,
                 .kind = can ? Captured::Kind::can : Captured::Kind::bytes};
    if (tapped.verdict != bus::Verdict::sent && tapped.verdict != bus::Verdict::taken)
        out.discarded = bus::to_word(tapped.verdict);
    if (can) {
        out.frame.can_id = tapped.can_id;
        out.frame.size = static_cast<std::uint8_t>(std::min<std::size_t>(tapped.bytes.size(), 8));
        std::copy_n(tapped.bytes.begin(), out.frame.size, out.frame.data.begin());
    } else {
        out.bytes.assign(tapped.bytes.begin(), tapped.bytes.end());
    }
    return out;
}

/// The time of day at which a real clock stood at zero.
inline Time time_of_day_zero(const link::Clock& clock)
{
    return std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now()) - clock.now().time_since_epoch();
}

} // namespace sinew::record
