#pragma once
#include "apps/cli/forecast.hpp"
#include "sinew/record/file.hpp"

/// Reads as fast as a bus goes, and counts.
namespace sinew::cli {

/// Times with the precision of a percent, in a fixed amount of memory.
class Percentiles
{
public:
    void add(Duration time);
    /// What this share (0 … 1) of the times did not exceed, rounded up to a percent; the longest is exact.
    Duration at(double share) const;
    Duration longest() const { return longest_; }
    std::uint64_t count() const { return count_; }

private:
    static std::size_t bucket_of(Duration time);

    std::array<std::uint64_t, 2400> buckets_{}; // 1 ns to 6 s, the last one for all beyond
    std::uint64_t count_ = 0;
    Duration longest_{};
};

struct Measured {
    Duration time{};
    std::uint64_t cycles = 0;
    std::uint64_t exchanges = 0;           ///< that brought their answer
    std::uint64_t losses = 0;              ///< that did not, retries included
    std::int64_t bits = 0;                 ///< that were on the wire, both ways, stuff bits included
    std::vector<bus::ExchangeBits> frames; ///< of each step, on average
    bus::Counters counters{};
    Percentiles round_trips;
    bool over = false; ///< ended with the recording that answered
};

/// Carries out the steps over and over for `time`, or until Ctrl-C. All of them must be reads: `bad_argument` before
/// anything is sent otherwise. Fails where the link is lost. `file`, if given, gets all frames. On a recording it ends
/// where that has nothing more to tell, and the silence behind its end is not measured.
std::expected<Measured, Error> measure(const Session& session, bus::Bus& bus, const BusTarget& target,
                                       std::span<const Step> steps, Duration time, record::FileWriter* file);

} // namespace sinew::cli
