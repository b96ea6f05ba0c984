#pragma once
#include "sinew/sim/wire/directory.hpp"
#include "sinew/sim/wire/faults.hpp"
#include "sinew/sim/wire/uart.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sinew::sim {

enum class Duplex : std::uint8_t {
    full, ///< TTL with a line for each direction (SAM): devices hear the host alone
    half, ///< one pair for all (RS-485, Nuri): devices hear each other, and nobody hears while it talks
};

/// What a receiver sees while two talkers disagree.
enum class Contention : std::uint8_t {
    wired_and, ///< a driven 0 wins: open drain
    garble,    ///< neither wins; each stretch of disagreement is a 0 or a 1 by chance
};

/// The host's adapter.
struct HostEnd {
    bool echo = false; ///< the host hears its own bytes
    /// Bytes reach the host in batches, at most this long after the first of them or as soon as there are 62: 1 or
    /// 16 ms on FTDI adapters, whose USB packets carry 64 bytes of which 2 are status. Source: FTDI AN232B-04.
    Duration usb_latency{};
};

/// The copper of a serial bus, true to the bit: bytes go out one after the other, ten bits each. Whoever is set to the
/// rate of a byte hears it; whoever is set to another one hears what its UART makes of the waveform. So it is where two
/// talk at once: the levels of both become one waveform, and each UART samples that.
///
/// Devices set to the same rate share one ear: their requests are cut out of the bytes once, with their framing, and
/// passed to those whom they are for. So the cost of an exchange does not grow with their number. What is no whole
/// request is given up after a silence: 20 byte times, at least 5 ms. UARTs alone would allow two byte times, but a
/// host behind a USB adapter pauses inside a frame for as long as its operating system likes, and the manuals name no
/// limit. A device that talks does not hear the requests that others' bytes make up meanwhile.
///
/// Single-threaded, driven by events, no heap after the last `attach`.
class SerialWire
{
public:
    static constexpr std::size_t host_capacity = 2048;
    static constexpr std::size_t spare_replies = 16; ///< at most one for each station, and these, wait; more are lost
    static constexpr std::size_t most_ears = 16;     ///< devices at still other rates are deaf

    explicit SerialWire(Duplex duplex)
        : duplex_(duplex), contention_(duplex == Duplex::full ? Contention::wired_and : Contention::garble)
    {
    }

    /// The station must outlive the wire. All that share a rate and a protocol share an ear.
    void attach(Station& station);
    /// Who hears the devices; nullptr: nobody. It must stay until another one, or nobody, takes its place.
    void connect(SerialHost* host);
    /// Finds out whether stations changed their id or rate by themselves. The wire notices on its own what they change
    /// when they hear a request or have answered; whoever moves them on calls this afterwards.
    void refresh();

    /// The host sends from `now` on, or when the bytes before these are out; they keep the rate given here. Returns how
    /// many fit. The wire has been run until `now`. At rate 0 nothing goes out and the bytes are lost.
    std::size_t host_sends(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate, TimePoint now);
    std::size_t host_room() const { return host_out_.room(); }

    /// `TimePoint::max()`: nothing will happen until the host sends.
    TimePoint next_event() const;
    /// All events up to `until` and at it, in the order of time.
    void run_until(TimePoint until);

    // ---- what may be set at any time ----

    WireFaults& faults() { return faults_; } ///< of all bytes
    /// Of the answers of one station, besides those of the wire. The first call asks the heap.
    void set_faults(const Station& station, const WireFaults& faults);
    void seed(std::uint64_t value) { dice_.seed(value); }
    HostEnd& host_end() { return host_end_; }
    void set_contention(Contention contention)
    {
        contention_ = contention;
    } ///< open drain on full, garble on half duplex
    /// Whether UARTs pass on a byte without its stop bit. The manuals do not say.
    void set_passes_broken_bytes(bool passes) { passes_broken_ = passes; }

private:
    using Number = Directory::Number;
    static constexpr Number the_host = ~Number{};

    struct Byte {
        std::uint8_t value = 0;
        bool is_last = false; ///< of its reply
        std::uint32_t bit_rate = 0;
        Number talker = the_host;
        TimePoint start{};
        TimePoint end{};
        TimePoint edge(int bit) const { return bit == bits_per_byte ? end : start + bit_time(bit, bit_rate); }
        bool level(int bit) const { return bit == 9 || (bit != 0 && (value >> (bit - 1) & 1) != 0); }
    };

    /// One direction of the wire, or the whole of it on half duplex.
    struct Line {
        std::vector<Byte> talking; ///< one, unless there is a collision
        bool collides = false;     ///< its levels have been heard up to `heard_to`; else the byte will be heard whole
        TimePoint heard_to{};
        TimePoint next_event() const;
    };

    /// An answer on its way, and how much of it is out.
    struct Reply {
        TimePoint start{};
        TimePoint next{}; ///< when its next byte goes out
        Number station = 0;
        std::uint32_t bit_rate = 0;
        std::uint8_t size = 0;
        std::uint8_t sent = 0;
        std::array<std::uint8_t, 2 * wire::Frame::capacity> bytes{};
    };

    /// When a station talks, last or next.
    struct Talk {
        TimePoint from{};
        TimePoint until{};
    };

    struct Ear {
        std::uint32_t bit_rate = 0;
        const wire::Protocol* protocol = nullptr;
        bool is_used = true;
        Sampler sampler;
        Receiver in;
        Duration patience{}; ///< what is no whole request after such a silence is given up
        TimePoint gives_up = TimePoint::max();
    };

    Line& from_host() { return lines_[0]; }
    Line& from_stations() { return lines_[duplex_ == Duplex::full ? 1 : 0]; }
    const Line& from_stations() const { return lines_[duplex_ == Duplex::full ? 1 : 0]; }
    std::uint32_t host_rate() const { return host_ != nullptr ? host_->bit_rate() : 0; }
    void step(TimePoint at);

    // talking: serial_talking.cpp
    std::size_t spoil(std::uint8_t byte, const WireFaults* station, std::span<std::uint8_t, 2> out);
    const WireFaults* faults_of(Number station) const;
    void reply(Number station, const Answer& answer, std::uint32_t bit_rate, TimePoint at);
    void start(Line& line, const Byte& byte);
    void start_host();
    void start_reply();
    void finish(Line& line, TimePoint at);
    void answered(Number station, TimePoint at);

    // hearing: serial_hearing.cpp
    void rebuild();
    template <class F>
    void for_each_listener(const Line& line, TimePoint at, F&& call);
    void begin_collision(Line& line);
    void hear_levels(Line& line, TimePoint until);
    void hear_alone(const Line& line, const Byte& byte);
    void hear_silence(TimePoint at);
    void hear(Ear& ear, std::uint8_t value, TimePoint start, TimePoint at);
    void find_requests(Ear& ear, bool silent, TimePoint at);
    void pass(const Ear& ear, const wire::Frame& request, TimePoint start, TimePoint at);
    void host_hears(std::uint8_t value, TimePoint at);
    void hand_over(TimePoint at);

    Duplex duplex_;
    Contention contention_;
    bool passes_broken_ = true;
    bool has_changed_ = false; ///< a station has; `rebuild` is due
    bool samples_ = false; ///< a UART may be inside a byte that it samples; without collisions and wrong rates none is
    WireFaults faults_;
    std::vector<WireFaults> station_faults_; ///< empty until the first is set
    Dice dice_;

    SerialHost* host_ = nullptr;
    HostEnd host_end_;
    Transmitter host_out_{host_capacity};
    Sampler host_in_;
    std::array<std::uint8_t, 62> batch_{};
    std::size_t batch_size_ = 0;
    TimePoint batch_due_ = TimePoint::max();

    Directory stations_;
    std::vector<Talk> talks_;    ///< one for each station
    std::vector<Reply> replies_; ///< a heap, the next one first
    std::vector<Ear> ears_;
    Line lines_[2];
};

} // namespace sinew::sim
