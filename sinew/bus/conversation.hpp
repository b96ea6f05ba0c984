#pragma once
#include "sinew/bus/counters.hpp"
#include "sinew/bus/predict.hpp"
#include "sinew/bus/settings.hpp"
#include "sinew/wire/protocol.hpp"
#include "sinew/wire/request.hpp"
#include "sinew/wire/select.hpp"

#include <array>
#include <span>

namespace sinew::bus {

/// How one request of an exchange ended. The caller owns the storage; the conversation keeps its progress in it.
struct Result {
    enum class Stage : std::uint8_t { waiting, sent, done };

    Stage stage = Stage::waiting;
    std::uint8_t tries = 0;
    std::uint8_t reply_count = 0;
    bool possibly_older = false; ///< an identical request timed out less than `late_max` before: it may be that answer
    TimePoint sent_at{};         ///< when its first bit went out
    TimePoint deadline{};
    TimePoint at{};                       ///< when the answer ended, or the request if none is due
    std::array<wire::Frame, 4> replies{}; ///< more than one only for messages that several devices answer
    Error error{};                        ///< of a request without an answer
    bool good = false;

    /// The answer, or why there is none. An empty frame where none is due.
    std::expected<wire::Frame, Error> reply() const
    {
        if (!good)
            return std::unexpected(error);
        return replies[0];
    }
};

/// The state machine of one bus: requests, bytes and time points go in; frames to send, a deadline or results come out.
/// No I/O, no clock, no heap. One exchange at a time.
///
/// On CAN all requests of an exchange go out back to back, one outstanding per identifier; on serial lines one after
/// the other. A reply must fit address and message of its request. Reads are retried. Where replies carry nothing to
/// tell them by, a time-out puts the line in quarantine: it must be silent for `late_max`, then the device must answer
/// a probe with its own id. What needs no answer goes out at once even then, and a command goes out although the probe
/// failed: a stop must reach a device whose answers do not come through.
class Conversation
{
public:
    struct Next {
        const wire::Frame* transmit = nullptr; ///< write this whole frame, call `transmitted`, and ask again
        TimePoint deadline{};                  ///< otherwise wait for input until then
        bool done = false;
    };

    Conversation(const wire::Protocol& protocol, Line line, Settings settings);

    /// Starts an exchange. Both spans must live until it is done and have one size.
    void begin(std::span<const wire::Request> requests, std::span<Result> results);
    Next next(TimePoint now);
    /// The frame that `next` gave out has been handed to the link at `now`.
    void transmitted(TimePoint now);
    void received(std::span<const std::uint8_t> bytes, TimePoint at);
    void received(const wire::Frame& frame, TimePoint at);
    /// The link was opened anew, or what came from it is doubtful for another reason: what has been heard is forgotten,
    /// a line of bare replies goes into quarantine, and elsewhere answers are marked as possibly older for `late_max`.
    void distrust(TimePoint now);
    /// Ends everything that is not done with `error`.
    void abandon(const Error& error, TimePoint now);

    void set_bit_rate(std::uint32_t bit_rate) { line_.bit_rate = bit_rate; }
    bool busy() const;
    Duration margin() const { return margin_; }
    const Counters& counters() const { return total_; }
    const Counters& counters(int id) const { return per_id_[slot_of(id)]; }

private:
    struct Timeout {
        int id = -1;
        const wire::MessageInfo* message = nullptr;
        TimePoint until{};
    };

    static std::size_t slot_of(int id) { return id >= 0 && id < 256 ? static_cast<std::size_t>(id) : 256; }
    Next next_serial(TimePoint now);
    Next next_can(TimePoint now);
    Next send(const wire::Request& request, Result& result, TimePoint now);
    bool identifier_free(std::size_t index) const;
    void quarantine(TimePoint now);
    bool begin_probe(const wire::Request& request);
    void end_probe();
    void take(const wire::Frame& frame, TimePoint at);
    void take_bytes(bool silent, TimePoint at);
    bool accept(const wire::Request& request, Result& result, const wire::Frame& frame, TimePoint at);
    void finish(const wire::Request& request, Result& result, TimePoint at);
    void time_out(const wire::Request& request, Result& result, TimePoint now);
    void stray(std::size_t count, TimePoint at);
    void learn(Duration excess);
    const wire::Request* current_request() const;
    Result* current_result();

    const wire::Protocol& protocol_;
    Line line_;
    Settings settings_;
    std::span<const wire::Request> requests_{};
    std::span<Result> results_{};
    std::size_t current_ = 0; // serial: the request in progress
    Result* sending_ = nullptr;
    const wire::Request* sending_request_ = nullptr;

    std::array<std::uint8_t, 256> buffer_{};
    std::size_t buffered_ = 0;

    bool quarantined_ = false;
    TimePoint quiet_until_{};
    TimePoint quarantine_ends_{};
    bool probing_ = false;
    bool unproven_ = false; // the probe failed, and a command goes out all the same
    wire::Request probe_{};
    Result probe_result_{};

    Duration margin_{};
    Duration excess_{};
    int measured_ = 0;
    std::array<Timeout, 8> timeouts_{}; // the latest ones
    std::size_t next_timeout_ = 0;
    TimePoint doubtful_until_{}; // every answer until then may be an older one

    Counters total_{};
    std::array<Counters, 257> per_id_{};
};

} // namespace sinew::bus
