#include "sinew/bus/predict.hpp"

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

} // namespace

Duration predict_cycle(const Line& line, std::span<const wire::Request> requests, Stuffing stuffing)
{
    Duration wire{};
    Duration response{};
    for (const auto& request : requests) {
        wire += predict(line, request, stuffing).wire();
        response += predict(line, request, stuffing).response;
    }
    return wire + (line.can ? longest_chain(line, requests) : response);
}

StopBound predict_stop(const Line& line, std::span<const wire::Request> running, std::span<const wire::Request> stop)
{
    StopBound bound;
    Duration queued{};
    for (const auto& request : running) {
        const Exchange one = predict(line, request);
        queued += line.can ? one.wire() : Duration{};
        bound.begins = std::max(bound.begins, line.can ? one.response : one.total());
    }
    bound.begins += queued;
    if (stop.empty()) {
        bound.first = bound.ends = bound.begins;
        return bound;
    }
    bound.first = bound.begins + predict(line, stop.front()).request;
    bound.ends = bound.begins + predict_cycle(line, stop);
    return bound;
}

} // namespace sinew::bus
