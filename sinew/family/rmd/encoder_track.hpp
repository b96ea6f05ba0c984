#pragma once
#include "sinew/base/time.hpp"

#include <cstdint>
#include <optional>

namespace sinew::rmd {

/// Follows the angle over all turns by the encoder value that every control reply carries, so that a control loop need
/// not ask for the angle as well.
///
/// No document says for every motor how wide its encoder is, on which side of the gear it sits and which way it counts.
/// So nothing is believed until it has been seen: between two angles that were really read, at least `proof_deg` apart,
/// the encoder must have turned as far. One angle that does not fit, but for whole turns, ends the belief for good.
/// Pure; angles as the motor counts them.
class EncoderTrack
{
public:
    explicit EncoderTrack(int bits) : steps_(std::int64_t{1} << bits) {}

    /// A reply with the encoder and the speed at `at`. The angle, where it is known without doubt: not after a gap in
    /// which the shaft could have turned so far that the turns cannot be counted.
    std::optional<double> encoder(std::int64_t raw, double speed_deg_s, TimePoint at);

    /// A reply with the angle at `at`.
    void angle(double angle_deg, TimePoint at);

    /// Whether the next encoder value, if it comes in time, will tell the angle.
    bool follows() const { return proven_ && !refuted_ && anchor_.has_value(); }
    /// The motor has started afresh, or has been given another zero.
    void forget();

    static constexpr double proof_deg = 5.0;
    static constexpr double tolerance_deg = 0.15;
    /// Longer apart, two encoder values are not of one movement, whatever the speed was at either.
    static constexpr Duration longest_gap = std::chrono::milliseconds{50};
    /// So far between two encoder values at most, in parts of a turn, that the shorter way is the right one.
    static constexpr double farthest_turn = 0.25;

private:
    /// An angle that was read, and where the encoder was then.
    struct Anchor {
        double angle_deg = 0.0;
        double encoder_deg = 0.0;
    };

    double deg(std::int64_t steps) const { return static_cast<double>(steps) * 360.0 / static_cast<double>(steps_); }
    void believe(double turned_deg, double encoder_turned_deg);

    std::int64_t steps_;
    std::int64_t total_ = 0; ///< steps over all turns, from wherever it began
    std::int64_t raw_ = 0;
    double speed_deg_s_ = 0.0;
    TimePoint at_{};
    bool has_encoder_ = false;
    std::optional<Anchor> anchor_;
    double sense_ = 1.0; ///< of the encoder against the angle
    bool proven_ = false;
    bool refuted_ = false;
};

} // namespace sinew::rmd
