#include "apps/cli/measure.hpp"

#include "sinew/record/tap.hpp"
#include "sinew/sim/wire/can_wire.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr double per_bucket = 1.01;

std::int64_t bits_of(const wire::Frame& frame, bool can)
{
    return can ? sim::can_frame_bits(frame) + sim::can_interframe_bits : bus::frame_bits(false, frame.size);
}

/// Bits of the frames of one step.
struct BitCount {
    std::int64_t request = 0, replies = 0, count = 0;

    bus::ExchangeBits average() const
    {
        const auto rounded = [&](std::int64_t sum) { return (sum + count / 2) / count; };
        return {rounded(request), rounded(replies)};
    }
};

} // namespace

std::size_t Percentiles::bucket_of(Duration time)
{
    const auto ns = std::max<std::int64_t>(time.count(), 1);
    return static_cast<std::size_t>(std::ceil(std::log(static_cast<double>(ns)) / std::log(per_bucket)));
}

void Percentiles::add(Duration time)
{
    ++buckets_[std::min(bucket_of(time), buckets_.size() - 1)];
    ++count_;
    longest_ = std::max(longest_, time);
}

Duration Percentiles::at(double share) const
{
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
        below += buckets_[i];
        if (below >= wanted && below > 0)
            return std::min(longest_, Duration{std::llround(std::pow(per_bucket, static_cast<double>(i)))});
    }
    return longest_;
}

std::expected<Measured, Error> measure(const Session& session, bus::Bus& bus, const BusTarget& target,
                                       std::span<const Step> steps, Duration time, record::FileWriter* file)
{
    std::vector<wire::Request> requests;
    for (const auto& step : steps) {
        if (step.request.message->info.access != wire::Access::read)
            return fail(Errc::bad_argument,
                        fmt::format("{} does not only read, and a measurement repeats it thousands of times; name a "
                                    "message that reads",
                                    step.request.message->name()));
        requests.push_back(step.request);
        requests.back().response_time = step.response_most;
    }
    Measured out;
    std::vector<BitCount> counts(requests.size());
    const bool can = target.family->can;
    const auto zero = record::time_of_day_zero(bus.clock());
    std::expected<void, Error> written;
    bus.set_tap([&](const bus::Tapped& tapped) {
        wire::Frame frame{.can_id = tapped.can_id,
                          .size = static_cast<std::uint8_t>(std::min(tapped.bytes.size(), std::size_t{8}))};
        if (can)
            std::copy_n(tapped.bytes.begin(), frame.size, frame.data.begin());
        out.bits += can ? bits_of(frame, true) : bus::frame_bits(false, tapped.bytes.size());
        if (file != nullptr && written)
            written = file->add(record::captured_from(tapped, target.name, target.family->name, can, zero));
    });
    std::vector<bus::Result> results(requests.size());
    const TimePoint begin = bus.clock().now();
    std::expected<void, Error> sent;
    while (sent && written && !interrupted() && bus.clock().now() - begin < time) {
        out.time = bus.clock().now() - begin;
        out.counters = bus.conversation().counters();
        const auto bits = out.bits;
        const auto told = session.replayed();
        sent = bus.exchange(requests, results);
        // A request that was not answered in the recording either is told as that.
        out.over = record::is_replay(bus.name()) && !std::ranges::all_of(results, &bus::Result::good) &&
                   session.replayed() - told < bus.conversation().counters().requests - out.counters.requests;
        if (out.over) {
            out.bits = bits;
            break;
        }
        for (std::size_t i = 0; i < results.size(); ++i) {
            const auto& result = results[i];
            if (result.good) {
                ++out.exchanges;
                ++counts[i].count;
                counts[i].request += bits_of(requests[i].frame, can);
                counts[i].replies += bits_of(result.replies[0], can);
                out.round_trips.add(result.at - result.sent_at);
            } else if (result.error.code != Errc::stopped) {
                ++out.losses;
            }
        }
        out.cycles += !interrupted();
    }
    if (!out.over) {
        out.time = bus.clock().now() - begin;
        out.counters = bus.conversation().counters();
    }
    bus.set_tap(nullptr);
    for (std::size_t i = 0; i < counts.size(); ++i)
        out.frames.push_back(counts[i].count > 0
                                 ? counts[i].average()
                                 : bus::ExchangeBits{bus::frame_bits(can, requests[i].frame.size),
                                                     bus::frame_bits(can, requests[i].message->reply.size)});
    if (!sent)
        return std::unexpected(sent.error());
    if (written && file != nullptr)
        written = file->flush();
    if (!written)
        return std::unexpected(written.error());
    return out;
}

} // namespace sinew::cli
