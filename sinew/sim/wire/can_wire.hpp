#pragma once
#include "sinew/sim/wire/directory.hpp"
#include "sinew/sim/wire/faults.hpp"
#include "sinew/sim/wire/ring.hpp"

#include <cstdint>
#include <vector>

namespace sinew::sim {

/// Bits between the end of a frame and the start of the next one.
inline constexpr int can_interframe_bits = 3;

/// Length on the wire of a data frame with an 11-bit identifier, from its start bit to the end of its end-of-frame
/// field: 44 bits + 8 for each byte + the stuff bits that identifier, data and CRC really need. Without the space that
/// follows. The frame has 8 bytes at most. Source: ISO 11898-1, classical base format.
int can_frame_bits(const wire::Frame& frame);

/// The copper of a CAN bus, true to the bit time: one frame at a time, each as long as its bits, and of those that are
/// ready when the bus falls idle the lowest identifier goes first. Each end sends its own frames in order.
///
/// Devices hear the frames of the host, at their own rate only, and pass them to whom they are for; the host hears the
/// frames of the devices. Ends that start one frame with the same bits in one instant are heard as one. If their data
/// differ, all see a bit error, an error frame passes, and all try again, again in one instant: after `most_tries` the
/// frames are given up. (A real controller would fall off the bus about then: an error costs it 8 of 256 points.)
/// Not modelled: a frame that nobody acknowledges is gone; devices do not hear each other.
///
/// Single-threaded, driven by events, no heap after the last `attach`.
class CanWire
{
public:
    static constexpr std::size_t host_capacity = 256;
    static constexpr std::size_t spare_replies = 16; ///< at most one for each station, and these, wait; more are lost
    static constexpr int most_tries = 32;

    /// What happened to the traffic so far.
    struct Counters {
        std::uint64_t error_frames = 0;
        std::uint64_t given_up = 0; ///< frames
    };

    /// The station must outlive the wire. All speak one protocol.
    void attach(Station& station);
    /// Who hears the devices; nullptr: nobody. It must stay until another one, or nobody, takes its place.
    void connect(CanHost* host) { host_ = host; }
    /// As `SerialWire::refresh`.
    void refresh()
    {
        if (stations_.has_changed())
            stations_.refresh();
    }

    /// Queues a frame of the host; false when the queue is full. The wire has been run until `now`. At rate 0 nothing
    /// goes out and the frame is lost, as is one of more than 8 bytes.
    bool host_sends(const wire::Frame& frame, std::uint32_t bit_rate, TimePoint now);

    /// How many frames `host_sends` takes now.
    std::size_t host_room() const { return host_out_.room(); }

    /// `TimePoint::max()`: nothing will happen until the host sends.
    TimePoint next_event() const;
    /// All events up to `until` and at it, in the order of time.
    void run_until(TimePoint until);
    const Counters& counters() const { return counters_; }

    // ---- what may be set at any time ----

    WireFaults& faults() { return faults_; } ///< of all frames
    /// Of the answers of one station, besides those of the wire. The first call asks the heap.
    void set_faults(const Station& station, const WireFaults& faults);
    void seed(std::uint64_t value) { dice_.seed(value); }

private:
    using Number = Directory::Number;
    static constexpr Number the_host = ~Number{};

    struct Ready {
        wire::Frame frame{};
        std::uint32_t bit_rate = 0;
        TimePoint from{};
        Number talker = the_host;
        std::uint32_t turn = 0; ///< of those of its station
    };

    /// Whose turn it is among the answers of one station.
    struct Turns {
        std::uint32_t given = 0;
        std::uint32_t served = 0;
    };

    enum class Outcome : std::uint8_t {
        heard,
        lost,
        repeated, ///< heard, and sent once more
        copy,     ///< that once more
        destroyed
    };

    bool is_ready(const Ready& reply, TimePoint at) const
    {
        return reply.from <= at && turns_[reply.talker].served == reply.turn;
    }
    template <class F>
    void for_each_ready(TimePoint at, F&& call) const;
    bool falls(double WireFaults::* fault);
    void start(TimePoint at);
    int bits_until_bit_error(TimePoint at) const;
    void finish();
    void remove(TimePoint at, bool is_given_up);
    void pass(const Ready& heard, TimePoint at);
    void reply(Number station, const Answer& answer, std::uint32_t bit_rate, TimePoint at);

    WireFaults faults_;
    std::vector<WireFaults> station_faults_; ///< empty until the first is set
    Dice dice_;
    Counters counters_;

    CanHost* host_ = nullptr;
    Ring<Ready> host_out_{host_capacity};
    Directory stations_;
    std::vector<Turns> turns_; ///< one for each station
    std::vector<Ready> replies_;

    bool busy_ = false;
    Ready on_wire_{}; ///< stays in its queue until it is through, as do all that are alike
    Outcome outcome_{};
    int tries_ = 0; ///< of this identifier in a row
    TimePoint started_{};
    TimePoint ends_{};
    TimePoint idle_{}; ///< when the next frame may start
};

} // namespace sinew::sim
