#include "sinew/family/rmd/encoder_track.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::rmd {
namespace {

constexpr double turn_deg = 360.0;

} // namespace

void EncoderTrack::forget()
{
    anchor_.reset();
    has_encoder_ = false;
}

std::optional<double> EncoderTrack::encoder(std::int64_t raw, double speed_deg_s, TimePoint at)
{
    if (refuted_)
        return {};
    if (raw >= steps_) { // a wider encoder than was said
        refuted_ = true;
        return {};
    }
    const double fastest = std::max(std::abs(speed_deg_s), std::abs(speed_deg_s_));
    const Duration gap = at - at_;
    const bool counted =
        has_encoder_ && gap >= Duration{} && gap <= longest_gap && fastest * seconds(gap) <= farthest_turn * turn_deg;
    if (!counted)
        anchor_.reset();
    std::int64_t step = counted ? raw - raw_ : 0;
    if (step > steps_ / 2)
        step -= steps_;
    else if (step < -steps_ / 2)
        step += steps_;
    total_ += step;
    raw_ = raw;
    speed_deg_s_ = speed_deg_s;
    at_ = at;
    has_encoder_ = true;
    if (!follows())
        return {};
    return anchor_->angle_deg + sense_ * (deg(total_) - anchor_->encoder_deg);
}

void EncoderTrack::believe(double turned_deg, double encoder_turned_deg)
{
    const double off = std::abs(turned_deg) - std::abs(encoder_turned_deg);
    if (std::abs(off) > tolerance_deg) {
        refuted_ = true;
        return;
    }
    sense_ = std::signbit(turned_deg) == std::signbit(encoder_turned_deg) ? 1.0 : -1.0;
    proven_ = true;
}

void EncoderTrack::angle(double angle_deg, TimePoint at)
{
    const Duration since = at - at_;
    if (refuted_ || !has_encoder_ || std::chrono::abs(since) > longest_gap)
        return;
    // The two were not measured at one moment; the speed tells the little between them.
    const double encoder_deg = deg(total_);
    const double angle_then = angle_deg - speed_deg_s_ * seconds(since);
    if (!anchor_) {
        anchor_ = Anchor{angle_then, encoder_deg};
        return;
    }
    const double turned = angle_then - anchor_->angle_deg;
    const double encoder_turned = encoder_deg - anchor_->encoder_deg;
    if (!proven_) {
        if (std::max(std::abs(turned), std::abs(encoder_turned)) >= proof_deg) {
            believe(turned, encoder_turned);
            anchor_ = Anchor{angle_then, encoder_deg};
        }
        return;
    }
    // Whole turns are the motor's to count: it may have lost them, but the encoder is still the same.
    const double off = std::remainder(turned - sense_ * encoder_turned, turn_deg);
    anchor_ = Anchor{angle_then, encoder_deg};
    refuted_ = std::abs(off) > tolerance_deg;
    if (refuted_)
        anchor_.reset();
}

} // namespace sinew::rmd
