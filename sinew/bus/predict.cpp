#include "sinew/bus/predict.hpp"

#include <vector>

namespace sinew::bus {
namespace {

bool share_identifier(const wire::Request& a, const wire::Request& b)
{
    return a.frame.can_id == b.frame.can_id || a.message->request.layout->can_fixed ||
           b.message->request.layout->can_fixed;
}

/// The response times of those that have to wait for each other.
Duration longest_chain(const Line& line, std::span<const wire::Request> requests)
{
    Duration longest{};
    for (std::size_t i = 0; i < requests.size(); ++i) {
        Duration chain{};
        for (std::size_t j = 0; j <= i; ++j)
            if (i == j || share_identifier(requests[i], requests[j]))
                chain += predict(line, requests[j]).response;
        longest = std::max(longest, chain);
    }
    return longest;
}

/// What no order of the frames on the wire exceeds.
Duration cycle_at_most(const Line& line, std::span<const wire::Request> requests)
{
    Duration wire{};
    Duration response{};
    for (const auto& request : requests) {
        wire += predict(line, request).wire();
        response += predict(line, request).response;
    }
    return wire + (line.can ? longest_chain(line, requests) : response);
}

/// The frames that are on their way at once: one request of each identifier, or one for several devices, alone.
Duration outstanding_at_most(const Line& line, std::span<const wire::Request> requests)
{
    Duration apart{};
    Duration alone{};
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const Duration own = predict(line, requests[i]).wire();
        const auto is_shorter_twin = [&](std::size_t j) {
            const Duration other = predict(line, requests[j]).wire();
            return requests[i].frame.can_id == requests[j].frame.can_id && (other > own || (other == own && j < i));
        };
        bool counts = true;
        for (std::size_t j = 0; j < requests.size() && counts; ++j)
            counts = !is_shorter_twin(j);
        if (requests[i].message->request.layout->can_fixed)
            alone = std::max(alone, own);
        else if (counts)
            apart += own;
    }
    return std::max(apart, alone);
}

/// The frames of a batch on a CAN bus, one after the other as they win it.
class CanSchedule
{
public:
    CanSchedule(const Line& line, std::span<const wire::Request> requests, std::span<const ExchangeBits> bits)
        : line_(line), requests_(requests), bits_(bits), progress_(requests.size())
    {
    }

    Duration run()
    {
        queue_what_may_go();
        while (done_ < requests_.size()) {
            const std::size_t winner = next();
            Progress& one = progress_[winner];
            const auto& request = requests_[winner];
            const bool is_request = one.stage == Stage::queued;
            now_ = std::max(now_, one.ready) +
                   bit_time(is_request ? bits_[winner].request : bits_[winner].reply, line_.bit_rate);
            if (is_request) {
                ++sent_;
                one.stage = Stage::answering;
                one.replies_left = reply_count(request);
                // The device heard the end of the frame, before the space that follows it.
                one.ready = now_ - bit_time(space_bits, line_.bit_rate) + request.response_time;
            } else {
                --one.replies_left;
            }
            if (one.replies_left == 0) {
                one.stage = Stage::done;
                ++done_;
                queue_what_may_go();
            }
        }
        return now_;
    }

private:
    static constexpr std::int64_t space_bits = 3;
    enum class Stage : std::uint8_t { waiting, queued, answering, done };
    struct Progress {
        Stage stage = Stage::waiting;
        int replies_left = 0;
        std::size_t place = 0; // in the queue of the host
        Duration ready{};
    };

    /// One outstanding per identifier, in the order in which they stand.
    void queue_what_may_go()
    {
        for (std::size_t i = 0; i < requests_.size(); ++i) {
            bool free = progress_[i].stage == Stage::waiting;
            for (std::size_t j = 0; j < i && free; ++j)
                free = progress_[j].stage == Stage::done || !share_identifier(requests_[i], requests_[j]);
            if (free)
                progress_[i] = {.stage = Stage::queued, .place = queued_++, .ready = now_};
        }
    }

    /// Of the frame that it puts on the wire next.
    std::uint32_t identifier(std::size_t i) const
    {
        const wire::Request& request = requests_[i];
        if (progress_[i].stage == Stage::queued)
            return request.frame.can_id;
        const std::uint32_t base = request.options.can_reply_base != 0 ? request.options.can_reply_base
                                                                       : request.message->reply.layout->can_base;
        return base + (request.frame.can_id - request.message->request.layout->can_base);
    }

    /// The frame that wins: of those that are ready first, the lowest identifier. The host sends in order.
    std::size_t next() const
    {
        const auto can_go = [&](const Progress& one) {
            return one.stage == Stage::answering || (one.stage == Stage::queued && one.place == sent_);
        };
        Duration start = Duration::max();
        for (const Progress& one : progress_)
            if (can_go(one))
                start = std::min(start, std::max(now_, one.ready));
        std::size_t winner = requests_.size();
        for (std::size_t i = 0; i < requests_.size(); ++i)
            if (can_go(progress_[i]) && progress_[i].ready <= start &&
                (winner == requests_.size() || identifier(i) < identifier(winner)))
                winner = i;
        return winner;
    }

    const Line& line_;
    std::span<const wire::Request> requests_;
    std::span<const ExchangeBits> bits_;
    std::vector<Progress> progress_;
    Duration now_{};
    std::size_t queued_ = 0, sent_ = 0, done_ = 0;
};

} // namespace

Duration predict_cycle(const Line& line, std::span<const wire::Request> requests, Stuffing stuffing)
{
    std::vector<ExchangeBits> bits;
    for (const auto& request : requests)
        bits.push_back({frame_bits(line.can, request.frame.size, stuffing),
                        frame_bits(line.can, request.message->reply.size, stuffing)});
    return predict_cycle(line, requests, bits);
}

Duration predict_cycle(const Line& line, std::span<const wire::Request> requests, std::span<const ExchangeBits> bits)
{
    if (line.can && line.bit_rate != 0)
        return CanSchedule(line, requests, bits).run();
    return cycle_at_most(line, requests);
}

StopBound predict_stop(const Line& line, std::span<const wire::Request> running, std::span<const wire::Request> stop)
{
    StopBound bound;
    for (const auto& request : running) {
        const Exchange one = predict(line, request);
        bound.begins = std::max(bound.begins, line.can ? one.response : one.total());
    }
    if (line.can)
        bound.begins += outstanding_at_most(line, running);
    if (stop.empty()) {
        bound.first = bound.ends = bound.begins;
        return bound;
    }
    bound.first = bound.begins + predict(line, stop.front()).request;
    bound.ends = bound.begins + cycle_at_most(line, stop);
    return bound;
}

} // namespace sinew::bus
