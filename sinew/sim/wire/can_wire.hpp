#pragma once
#include "sinew/sim/wire/ring.hpp"
#include "sinew/sim/wire/station.hpp"

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
/// Devices hear the frames of the host, at their own rate only; the host hears the frames of the devices. Not modelled:
/// error frames, retransmission (a frame that nobody acknowledges is gone), devices that hear each other, and two ends
/// with one identifier in one instant (the host goes first, then the station that was attached first).
///
/// Single-threaded, driven by events, no heap after the last `attach`.
class CanWire
{
public:
    static constexpr std::size_t host_capacity = 256;
    static constexpr std::size_t station_capacity = 16; ///< an answer that does not fit is not given

    /// The station must outlive the wire.
    void attach(Station& station);
    /// Who hears the devices; nullptr: nobody. It must stay until another one, or nobody, takes its place.
    void connect(CanHost* host) { host_ = host; }

    /// Queues a frame of the host; false when the queue is full. The wire has been run until `now`. At rate 0 nothing
    /// goes out and the frame is lost, as is one of more than 8 bytes.
    bool host_sends(const wire::Frame& frame, std::uint32_t bit_rate, TimePoint now);

    /// `TimePoint::max()`: nothing will happen until the host sends.
    TimePoint next_event() const;
    /// All events up to `until` and at it, in the order of time.
    void run_until(TimePoint until);

private:
    struct Ready {
        wire::Frame frame{};
        std::uint32_t bit_rate = 0;
        TimePoint from{};
    };

    struct Node {
        Station* station = nullptr; ///< nullptr: the host
        Ring<Ready> queue;
    };

    void start(TimePoint at);
    void finish();

    CanHost* host_ = nullptr;
    std::vector<Node> nodes_ = {{.queue = Ring<Ready>(host_capacity)}}; ///< the host is the first
    bool busy_ = false;
    Ready on_wire_{};
    Station* talker_ = nullptr;
    TimePoint ends_{};
    TimePoint idle_{}; ///< when the next frame may start
};

} // namespace sinew::sim
