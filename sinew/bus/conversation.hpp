#pragma once
#include "sinew/bus/counters.hpp"
#include "sinew/bus/lateness.hpp"
#include "sinew/bus/predict.hpp"
#include "sinew/bus/settings.hpp"
#include "sinew/bus/tap.hpp"
#include "sinew/wire/protocol.hpp"
#include "sinew/wire/request.hpp"

#include <array>
#include <bit>
#include <bitset>
#include <functional>
#include <span>

namespace sinew::bus {

/// How one request of an exchange ended. The caller owns the storage; the conversation keeps its progress in it.
struct Result {
    enum class Stage : std::uint8_t { waiting, sent, done };

    Stage stage = Stage::waiting;
    std::uint8_t tries = 0;    ///< how often it went out
    std::uint8_t failures = 0; ///< how many of these came to nothing
    std::uint8_t reply_count = 0;
    bool good = false;
    /// The answer may be that of an earlier request like it: one timed out less than `late_max` before, or the line was
    /// distrusted then.
    bool possibly_older = false;
    TimePoint sent_at{};  ///< when its first bit went out
    TimePoint due{};      ///< when its answer has ended at the latest if the link adds nothing
    TimePoint deadline{}; ///< when it is given up: `due` and the margin
    /// When the answer ended, or the request if none is due, or when it was given up. What was read later than
    /// `deadline`, because the program was kept from running, had come by then.
    TimePoint at{};
    std::array<wire::Frame, 4> replies{}; ///< `reply_count` of them; more than one only where several devices answer
    Error error{};                        ///< of a request without an answer

    /// The answer, or why there is none. An empty frame where none is due.
    std::expected<wire::Frame, Error> reply() const
    {
        if (!good)
            return std::unexpected(error);
        return answer();
    }
    /// The answer of a good one; an empty frame where none is due.
    const wire::Frame& answer() const
    {
        static constexpr wire::Frame nothing{};
        return reply_count > 0 ? replies[0] : nothing;
    }
    /// As new, but for what is not looked at before it is written.
    void reset()
    {
        stage = Stage::waiting;
        tries = failures = reply_count = 0;
        good = possibly_older = false;
    }
};

/// The state machine of one bus: requests, bytes and time points go in; frames to send, a deadline or results come out.
/// No I/O, no clock, no heap. One exchange at a time.
///
/// On CAN all requests of an exchange go out back to back, one outstanding per identifier; on serial lines one after
/// the other. A reply must fit address and message of its request and cannot end before the wire could have carried it.
/// Reads are retried, commands as `Settings` has it. Where replies carry nothing to tell them by, a time-out or a byte
/// too many puts the line in quarantine: it must be silent for `late_max`, then the device must answer a probe with its
/// own id; until then nothing that comes is taken. What needs no answer goes out at once even then, and a command goes
/// out although the probe failed, but its answer is not believed: a stop must reach a device whose answers do not come
/// through.
class Conversation
{
public:
    struct Next {
        /// Hand over as many of these whole frames as the link takes, say how many to `transmitted`, and ask again.
        /// They stay valid until then.
        std::span<const wire::Frame> transmit{};
        TimePoint deadline = TimePoint::max(); ///< otherwise wait for input until then
        bool done = false;
    };

    Conversation(const wire::Protocol& protocol, Line line, Settings settings);

    /// Starts an exchange when none is running. Both spans must live until it is done and have one size. While a stop
    /// is under way everything ends with `stopped` at once.
    void begin(std::span<const wire::Request> requests, std::span<Result> results);
    /// Cuts in with an exchange of its own at the next frame boundary: `predict_stop` says how late that is at worst.
    /// What then is not done ends with `stopped`. The requests go out whatever the state of the line, each waits for
    /// its answer no longer than the wire needs, and none is retried. Both spans must live until it is done.
    void begin_stop(std::span<const wire::Request> requests, std::span<Result> results);
    /// Between `begin_stop` and the end of that exchange.
    bool stopping() const { return unusual_.stop_due || unusual_.urgent; }

    Next next(TimePoint now);
    /// So many of the frames that `next` gave out, and at least one, have been handed to the link at `now`.
    void transmitted(std::size_t count, TimePoint now);
    void received(std::span<const std::uint8_t> bytes, TimePoint at);
    void received(const wire::Frame& frame, TimePoint at);
    /// The link was opened anew, or what came from it is doubtful for another reason: what has been heard is forgotten,
    /// a line of bare replies goes into quarantine, and elsewhere answers are marked as possibly older for `late_max`.
    void distrust(TimePoint now);
    // ---- the same in fewer steps, for one request that one device is to answer; inline in conversation_hot.hpp ----

    /// Nothing goes on and nothing is in doubt, so its frame may be handed over without `begin`.
    bool is_calm() const { return (open_ | buffered_ | unusual_.all()) == 0; }
    /// The counters of a device, for the two that follow.
    Counters& own_counters(int id) { return per_id_[slot_of(id)]; }
    /// That has been done, beginning at `now`. The conversation knows nothing of it, and nothing else may be asked of
    /// it, until `answered_plain` or `adopt`.
    template <bool IsCan>
    inline void sent_plain(const wire::Request& request, Result& result, Counters& own, TimePoint now);
    /// Takes the answer, whole and with nothing before or behind it: then all is over. False where it is anything else.
    inline bool answered_plain(const wire::Request& request, Result& result, Counters& own,
                               std::span<const std::uint8_t> bytes, TimePoint at);
    /// The same for a frame that stands in `result.replies[0]`.
    inline bool answered_plain(const wire::Request& request, Result& result, Counters& own, TimePoint at);
    /// From here on it is an exchange like any other.
    void adopt(const wire::Request& request, Result& result);

    /// Ends everything that is not done with `error`.
    void abandon(const Error& error, TimePoint now);

    void set_bit_rate(std::uint32_t bit_rate)
    {
        line_.bit_rate = bit_rate;
        times_ = Timetable(line_);
    }
    /// Called for every frame, in both directions, from the thread that drives.
    void set_tap(std::function<void(const Tapped&)> tap)
    {
        tap_ = std::move(tap);
        unusual_.tapped = static_cast<bool>(tap_);
    }
    bool busy() const { return open_ != 0 || stopping(); }
    Duration margin() const { return margin_; }
    const Line& line() const { return line_; }
    const Settings& settings() const { return settings_; }
    const Counters& counters() const { return total_; }
    const Counters& counters(int id) const { return per_id_[slot_of(id)]; }
    /// No exchange of these requests takes longer, whatever happens on the wire, if the link takes its frames at once.
    Duration longest(std::span<const wire::Request> requests) const;

private:
    static constexpr std::size_t most_at_once = 64; // frames that are handed to a CAN link together

    static std::size_t slot_of(int id) { return id >= 0 && id < 256 ? static_cast<std::size_t>(id) : 256; }
    void count(std::uint64_t Counters::* counter, int id, std::uint64_t more = 1)
    {
        total_.*counter += more;
        per_id_[slot_of(id)].*counter += more;
    }
    void tell(Verdict verdict, std::span<const std::uint8_t> bytes, TimePoint at, std::uint32_t can_id = 0) const
    {
        if (tap_) [[unlikely]]
            tap_({at, verdict == Verdict::sent ? wire::Direction::request : wire::Direction::reply, bytes, can_id,
                  verdict});
    }

    // both kinds: conversation.cpp
    inline void sent(const wire::Request& request, Result& result, TimePoint due, TimePoint now);
    inline bool accept(const wire::Request& request, Result& result, const wire::Frame& frame, TimePoint at);
    bool accept_from_one(const wire::Request& request, Result& result, const wire::Frame& frame, TimePoint at);
    void finish_unanswered(const wire::Request& request, TimePoint at);
    static inline void arrived(Result& result, TimePoint read_at);
    inline void finish(const wire::Request& request, Result& result, TimePoint at);
    void time_out(const wire::Request& request, Result& result, TimePoint now);
    void give_up(const wire::Request& request, Result& result, Errc why, TimePoint now);
    bool may_repeat(const wire::Request& request, const Result& result) const;
    void abandon(const wire::Request& request, Result& result, const Error& error, TimePoint now);
    static void end(const wire::Request& request, Result& result, const Error& error);
    void cut_in(TimePoint now);
    void discard(const wire::Frame& frame, TimePoint at);
    inline void note_answer(const wire::Request& request, Result& result, unsigned frames, Counters& own, TimePoint at);
    inline TimePoint earliest(Duration request, Duration replies, TimePoint sent_at) const;
    inline void learn(Duration excess);

    // serial lines: conversation_serial.cpp
    Next next_serial(TimePoint now);
    bool in_flight() const;
    bool is_confirmed(const wire::Request& request, Result& result, TimePoint at);
    void quarantine(TimePoint now);
    void begin_probe(const wire::Request& request);
    void end_probe(TimePoint now);
    void receive_bare(std::span<const std::uint8_t> bytes, TimePoint at);
    std::size_t receive_framed(std::span<const std::uint8_t> bytes, bool silent, TimePoint at);
    void stray(Verdict verdict, std::span<const std::uint8_t> bytes, TimePoint at);
    void drop_buffered(TimePoint at);
    const wire::Request* own_request(const wire::Frame& frame) const;
    const wire::Request* current_request() const { return unusual_.probing ? &probe_ : &requests_[current_]; }
    Result* current_result() { return unusual_.probing ? &probe_result_ : &results_[current_]; }
    const Result* current_result() const { return unusual_.probing ? &probe_result_ : &results_[current_]; }

    // CAN: conversation_can.cpp
    Next next_can(TimePoint now);
    inline void transmitted_can(std::size_t count, TimePoint now);
    void expire(TimePoint now);
    void gather(TimePoint now);
    inline void put_into_outbox(std::size_t i, TimePoint now);
    void take_back(std::size_t kept);
    inline void release(const wire::Request& request);
    inline bool take(std::size_t i, const wire::Frame& frame, TimePoint at);
    TimePoint last_due() const;

    /// What an exchange that takes its usual way need not ask for one by one.
    struct Unusual {
        bool stop_due = false;    // the stop waits for the frame boundary
        bool urgent = false;      // the stop is what runs
        bool quarantined = false; // the line
        bool probing = false;
        bool unproven = false; // the probe failed, and a command goes out all the same
        bool tapped = false;
        bool double_read = false;
        bool unused = false;
        std::uint64_t all() const { return std::bit_cast<std::uint64_t>(*this); }
    };

    const wire::Protocol& protocol_;
    const bool bare_; // replies
    Unusual unusual_{};
    Line line_;
    Timetable times_;
    Settings settings_;
    std::function<void(const Tapped&)> tap_;
    std::span<const wire::Request> requests_{};
    std::span<Result> results_{};
    std::size_t open_ = 0; // results that are not done

    // serial
    std::size_t current_ = 0; // the request in progress
    TimePoint earliest_{};    // what comes before is no answer to it
    std::array<std::uint8_t, 256> buffer_{};
    std::size_t buffered_ = 0;
    TimePoint quiet_until_{};
    TimePoint quarantine_ends_{};
    wire::Request probe_{};
    Result probe_result_{};

    // CAN
    std::array<wire::Frame, most_at_once> outbox_{};
    std::array<std::uint16_t, most_at_once> outbox_of_{}; // whose frames they are
    std::size_t outbox_size_ = 0;
    std::bitset<2048> outstanding_{}; // identifiers, of the outbox as well
    std::size_t sent_count_ = 0;
    std::size_t waiting_count_ = 0;
    Duration on_wire_{};                          // of all that is outstanding, both ways
    TimePoint clear_at_{};                        // when the wire has carried what was abandoned
    TimePoint first_expiry_{};                    // nothing that is outstanding is given up before
    std::size_t likely_ = 0;                      // whose answer comes next if they come in order
    std::array<std::uint16_t, 2048> latest_of_{}; // whose answer came with this identifier most recently

    std::span<const wire::Request> stop_requests_{};
    std::span<Result> stop_results_{};

    Duration margin_{};
    Duration excess_{};
    int measured_ = 0;
    Lateness lateness_;

    Counters total_{};
    std::array<Counters, 257> per_id_{};
};

} // namespace sinew::bus
