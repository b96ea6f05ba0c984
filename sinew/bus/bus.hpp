#pragma once
#include "sinew/bus/conversation.hpp"
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/reopen.hpp"
#include "sinew/wire/codec.hpp"

#include <atomic>
#include <bit>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// One link, one family: the conversation on it. A user's calls end here.
namespace sinew::bus {

/// What the bus must know of a device: its firmware line, and how fast it answers.
struct Device {
    const wire::Profile* line = nullptr; ///< messages that it does not list are refused; nullptr: no such check
    wire::Options options{};
    Duration response_time{};
};

/// Owns its link and talks over it from the caller's thread. One thread at a time, except `request_stop`. In the steady
/// state an exchange uses no heap and no system call but one write, one wait and one read; where replies are bare, one
/// more read before it throws away what nobody asked for.
///
/// A link that hangs up is closed at once. The exchange in progress, or the next one where none was, ends with
/// `link_lost`: once for every loss somebody is told, for devices that lost their power have forgotten where they were.
/// The link stays lost unless `set_reopen` says how it comes back.
class Bus
{
public:
    /// The clock and the protocol must outlive the bus.
    Bus(std::string name, link::AnyLink link, link::Clock& clock, const wire::Protocol& protocol,
        Settings settings = {});
    ~Bus();
    Bus(const Bus&) = delete;
    Bus& operator=(const Bus&) = delete;

    /// Tells the bus about a device. Of an id that was never told nothing is known: any row of the family goes out.
    void set_device(int id, Device device);
    const Device& device(int id) const { return devices_[slot_of(id)]; }

    /// Carries out all requests and fills one result each. The spans have one size. Fails as a whole only when the link
    /// is lost; then every result that was not done carries the same error.
    std::expected<void, Error> exchange(std::span<const wire::Request> requests, std::span<Result> results);

    /// One request and its answer.
    template <class M>
    std::expected<wire::ReplyOf<M>, Error> call(int id, const M& message);

    /// One request for which no answer is due: Nuri settings and motion, SAM commands at response level 0, broadcasts.
    template <class M>
    std::expected<void, Error> send(int id, const M& message);

    /// A request for this bus, with what it knows of the device. `not_in_profile` where the device's line does not list
    /// the message.
    template <class M>
    std::expected<wire::Request, Error> request(int id, const M& message) const;

    /// Another bit rate for this host's end of the line; the devices keep theirs.
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate);

    // ---- the stop ----

    /// What goes out when a stop is asked for, in this order: a broadcast first where the family has one, then each
    /// device. Nothing yet: a stop only ends what runs. One that begins after `until` sends `later` in their place:
    /// what names where a shaft was is not true for ever. Not while an exchange runs; asks the heap for more than
    /// before.
    void set_stop(std::span<const wire::Request> requests, TimePoint until = TimePoint::max(),
                  std::span<const wire::Request> later = {});
    /// Ends what runs at the next frame boundary with `stopped`, sends the stop requests, and ends every later exchange
    /// at once until `clear_stop`. Whoever drives the bus carries it out, if nobody does the next `drive` or
    /// `exchange`. May be called from any thread and from a signal handler.
    void request_stop() noexcept;
    /// The same from the thread that drives, and returns when it is carried out.
    void stop();
    /// How the requests of the latest stop ended, until the next one begins: a good result is the device's own word.
    std::span<const Result> stop_results() const { return std::span(stop_results_).first(stop_size_); }
    /// Whether that sent what is right later.
    bool said_later() const { return said_later_; }
    void clear_stop() noexcept;
    /// Losing the link of this bus stops these, which must outlive it.
    void stop_when_lost(std::vector<Bus*> others) { stopped_with_ = std::move(others); }
    /// How late a stop is at worst, counted from `request_stop`, while `running` is exchanged; without the host's time.
    StopBound stop_bound(std::span<const wire::Request> running) const;

    // ---- the link ----

    /// Lets the bus open its link again after a loss, such as with `link::Links::reopener`; an empty function leaves it
    /// lost, as it is at the start.
    ///
    /// While the link is lost every exchange first tries to open it, at most once in `period`, and ends at once with
    /// `link_lost` and the reason when that fails: nothing waits and no thread runs. A program that exchanges, or calls
    /// `tend`, more often than that has its link back within two periods after the device. It comes back with the bit
    /// rate that was set last, and in doubt: see `Conversation::distrust`. What devices forgot is not set again.
    void set_reopen(link::Reopen reopen, Duration period = std::chrono::milliseconds(100));

    /// For a program that asks nothing at the moment (never between `start` and the end of its exchange): notices a
    /// hang-up, drops what came unasked, and tries to open a lost link. Returns when it wants to be called again; a
    /// wait looks at `handles()` as well.
    TimePoint tend();

    /// Tends the link until it is open, a stop is asked for or `until` has come. Whether it is open.
    bool wait_for_link(TimePoint until);

    std::uint64_t losses() const { return losses_; } ///< how often the link was lost
    /// Why there is no link; nullptr while it is open.
    const Error* link_trouble() const { return trouble_.lost ? &lost_error_ : nullptr; }

    /// Shows every frame with its time and what became of it.
    void set_tap(std::function<void(const Tapped&)> tap) { conversation_.set_tap(std::move(tap)); }
    const std::string& name() const { return name_; }
    const wire::Protocol& protocol() const { return protocol_; }
    link::Clock& clock() const { return clock_; }
    link::LinkState link_state() const;
    const link::AnyLink& link() const { return link_; } ///< to look at
    const Conversation& conversation() const { return conversation_; }

    // ---- for `drive` ----

    /// Begins an exchange without waiting for it. One that is still running ends with `stopped`; a frame of it of which
    /// the link has taken a part is finished before.
    void start(std::span<const wire::Request> requests, std::span<Result> results);
    /// Reads, writes and moves on as far as it goes without waiting. True when the exchange has ended.
    bool work();
    TimePoint deadline() const { return deadline_; }
    /// A stop was asked for that `work` can obey and has not yet: a frame that has begun is finished before.
    bool has_news() const
    {
        return stop_.load(std::memory_order_relaxed) && !stop_begun_ && !trouble_.lost && written_ == 0;
    }
    /// What a wait has to look at: the link, and the stop.
    std::span<const link::Handle> handles();

private:
    static constexpr std::size_t read_size = 256;

    static std::size_t slot_of(int id) { return id >= 0 && id < 256 ? static_cast<std::size_t>(id) : 256; }
    bool is_listed(int id, const wire::MessageInfo& message) const
    {
        return listed_[slot_of(id)] == &message || look_up(id, message);
    }
    bool look_up(int id, const wire::MessageInfo& message) const;
    void read_link();
    bool take(const std::expected<link::Arrival, Error>& got, std::span<const std::uint8_t> buffer);
    bool take_frames(const std::expected<link::Arrival, Error>& got, std::span<const wire::Frame> frames);
    bool write(std::span<const wire::Frame> frames, TimePoint& now);
    template <class M>
    std::expected<wire::ReplyOf<M>, Error> refuse(int id, const M& message) const;
    template <class M>
    static std::expected<wire::ReplyOf<M>, Error> failed(const Result& result);
    std::expected<std::size_t, Error> hand_over(std::span<const wire::Frame> frames);
    std::size_t take_note(const wire::Frame& frame, std::size_t count);
    bool note_written(const std::expected<std::size_t, Error>& wrote, const wire::Frame& first, TimePoint& now);
    void obey_stop();
    void end_wake() noexcept;
    void end_with(const Error& error);
    void try_to_reopen();
    std::expected<void, Error> adopt(link::AnyLink link);
    void run(std::span<const wire::Request> requests, std::span<Result> results);
    void one(const wire::Request& request, Result& result);
    void one_in_bytes(const wire::Request& request, Result& result);
    void one_in_frames(const wire::Request& request, Result& result);
    bool is_silent();
    void half_written(const wire::Request& request, Result& result, const std::expected<std::size_t, Error>& wrote,
                      TimePoint before);
    void go_on();
    void choose_kind();

    std::string name_;
    link::AnyLink link_;
    link::ByteLink* bytes_ = nullptr; // one of the two is `link_`
    link::CanLink* can_ = nullptr;
    link::Clock& clock_;
    const wire::Protocol& protocol_;
    const bool bare_; // replies
    Conversation conversation_;
    std::array<Device, 257> devices_{};
    mutable std::array<const wire::MessageInfo*, 257> listed_{}; // found in the device's line when last looked for

    struct Trouble {
        bool lost = false;    // the link
        bool untold = false;  // a loss that has ended no exchange yet
        bool blocked = false; // the link takes no more
        bool unused = false;
        bool any() const { return std::bit_cast<std::uint32_t>(*this) != 0; }
    };
    Trouble trouble_{};

    bool look_ = true;            // there may be something to read
    wire::Frame part_{};          // a frame of which a part is still to be written
    std::size_t written_ = 0;     // of it
    bool abandoned_part_ = false; // it is of an exchange before this one
    TimePoint write_deadline_{};
    TimePoint deadline_{};
    std::array<link::Handle, 2> handles_{};
    std::array<link::Handle, 2> usual_handles_{}; // while the link takes frames
    Result single_{};                             // of `call` and `send`
    std::array<wire::Frame, 64> inbox_{};         // of a CAN link

    std::atomic<bool> stop_{false};
    bool stop_begun_ = false;
    int stop_event_ = -1;
    std::vector<wire::Request> stop_requests_, later_stop_requests_;
    TimePoint stop_until_ = TimePoint::max();
    std::vector<Result> stop_results_;
    std::size_t stop_size_ = 0; // of those of the stop that began last
    bool said_later_ = false;
    std::vector<Bus*> stopped_with_;

    bool ended_by_loss_ = false; // the latest exchange
    Error lost_error_{};
    link::Reopen reopen_;
    Duration reopen_period_{};
    TimePoint next_try_{};
    std::uint32_t asked_bit_rate_ = 0; // 0: as the link was opened
    std::uint64_t losses_ = 0;
};

/// Works on all buses at once, however many, in this thread, until every exchange has ended or `until` has come. All
/// buses share one clock. Returns false when time ran out first.
bool drive(std::span<Bus* const> buses, TimePoint until = TimePoint::max());

template <class M>
std::expected<wire::Request, Error> Bus::request(int id, const M& message) const
{
    const Device& to = device(id);
    if (to.line != nullptr && !is_listed(id, wire::info_of<M>))
        return std::unexpected(Error{.code = Errc::not_in_profile, .message = wire::info_of<M>.name(), .id = id});
    return wire::make_request(id, message, to.options, to.response_time);
}

template <class M>
std::expected<wire::ReplyOf<M>, Error> Bus::call(int id, const M& message)
{
    constexpr auto asks = wire::Direction::request;
    const Device& to = device(id);
    wire::Request asked = wire::detail::blank_request<M>(id, to.options, to.response_time);
    const bool is_good =
        (to.line == nullptr || is_listed(id, wire::info_of<M>)) &&
        wire::detail::encode<M, asks>(asked.frame, id, message, to.options, wire::detail::parts<M, asks>);
    if (!is_good) [[unlikely]]
        return refuse(id, message);
    constexpr bool by_one = wire::info_of<M>.reply.exists() && !wire::info_of<M>.request.layout->can_fixed;
    constexpr bool by_all = wire::row<M>.info.broadcast; // perhaps; then nobody answers
    const bool has_answer = by_one && (!by_all || asked.answered);
    has_answer ? one(asked, single_) : run({&asked, 1}, {&single_, 1});
    if (!single_.good) [[unlikely]]
        return failed<M>(single_);
    static constexpr wire::Frame nothing{};
    return wire::decode_answer<M>(has_answer || asked.answered ? single_.replies[0] : nothing, to.options);
}

template <class M>
[[gnu::cold, gnu::noinline]] std::expected<wire::ReplyOf<M>, Error> Bus::refuse(int id, const M& message) const
{
    return std::unexpected(request(id, message).error());
}

template <class M>
[[gnu::cold, gnu::noinline]] std::expected<wire::ReplyOf<M>, Error> Bus::failed(const Result& result)
{
    return std::unexpected(result.error);
}

template <class M>
std::expected<void, Error> Bus::send(int id, const M& message)
{
    auto asked = request(id, message);
    if (!asked)
        return std::unexpected(asked.error());
    asked->answered = false;
    run({&*asked, 1}, {&single_, 1});
    if (!single_.good)
        return std::unexpected(single_.error);
    return {};
}

} // namespace sinew::bus
