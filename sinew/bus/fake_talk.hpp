#pragma once

#include "sinew/bus/conversation.hpp"
#include "sinew/bus/fake_family.hpp"

#include <optional>
#include <utility>
#include <vector>

/// A conversation that a test holds word by word: what goes out, what is heard, and when.
namespace sinew::bus::fake {

using namespace std::chrono_literals;

inline constexpr std::uint32_t bit_rate = 100'000; // a byte takes 100 µs
inline constexpr Settings settings{
    .margin_at_first = 10ms, .margin_least = 1ms, .late_max = 50ms, .read_retries = 1, .paced = false};

/// A conversation with its requests and a clock that the test turns.
struct Talk {
    explicit Talk(const wire::Protocol& protocol, bool is_can = false)
        : conversation(protocol, {.can = is_can, .bit_rate = bit_rate}, settings), on_can(is_can)
    {
    }

    template <class... Messages>
    void ask(std::pair<int, Messages>... asked)
    {
        requests = {*wire::make_request(asked.first, asked.second)...};
        results.assign(requests.size(), {});
        conversation.begin(requests, results);
    }

    /// What goes out now, if anything; on a serial line one request alone, or it is not taken.
    std::optional<wire::Frame> sent()
    {
        const auto next = conversation.next(now);
        if (next.transmit.empty() || (!on_can && next.transmit.size() > 1))
            return std::nullopt;
        const wire::Frame frame = next.transmit.front();
        conversation.transmitted(1, now);
        return frame;
    }

    TimePoint deadline() { return conversation.next(now).deadline; }
    bool done() { return conversation.next(now).done; }
    void hear(std::vector<std::uint8_t> bytes) { conversation.received(bytes, now); }

    Conversation conversation;
    bool on_can;
    TimePoint now{1s};
    std::vector<wire::Request> requests;
    std::vector<Result> results;
};

} // namespace sinew::bus::fake
