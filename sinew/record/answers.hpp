#pragma once
#include "sinew/record/captured.hpp"

#include <deque>
#include <map>

namespace sinew::record {

/// What one bus of a recording answered to each request. Pure.
class Answers
{
public:
    /// The latest that an answer on CAN may follow its request, where nothing but the order tells them apart.
    static constexpr Duration answer_most = std::chrono::milliseconds(10);

    struct Reply {
        Duration after{}; ///< the request, until its end has arrived
        Captured said;
    };

    /// In the order of the recording. What the host only heard of itself (an echo) is no answer.
    void add(const Captured& captured);
    /// The answers to the next occurrence of this request; empty: none were recorded, or all of them were given. What
    /// was asked only once, such as a setting, is answered so again and again.
    std::span<const Reply> next(std::uint32_t can_id, std::span<const std::uint8_t> bytes, bool loop);
    /// All requests from the beginning again.
    void rewind();
    /// Requests that met another occurrence than before; where that stands still the recording has no more to say.
    std::uint64_t given() const { return given_; }
    bool has_requests() const { return !requests_.empty(); }
    bool is_can() const { return can_; }

private:
    using Key = std::pair<std::uint32_t, std::vector<std::uint8_t>>;
    struct Request {
        std::vector<std::vector<Reply>> times; // one for each time that it was sent
        std::size_t given = 0;
    };
    struct Open { // a request that may be answered yet
        Key key;
        std::size_t time = 0;
        Time at{};
        bool answered = false;
    };
    Open* asked_by(const Captured& reply);
    void begin(const Captured& request);

    std::map<Key, Request> requests_;
    std::deque<Open> open_;
    std::uint64_t given_ = 0;
    bool can_ = false;
};

} // namespace sinew::record
