#pragma once
#include "sinew/sim/wire/station.hpp"
#include "sinew/sim/wire/uart.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace sinew::sim {

enum class Duplex : std::uint8_t {
    full, ///< TTL with a line for each direction (SAM): devices hear the host alone
    half, ///< one pair for all (RS-485, Nuri): devices hear each other, and nobody hears while it talks
};

/// The copper of a serial bus, true to the bit time: bytes go out one after the other, ten bits each, and whoever is
/// set to another rate does not hear them (a UART would see framing errors; that garbage is not modelled). There is no
/// echo.
///
/// A device cuts requests out of what it hears with its own framing. What is no whole request is given up after a
/// silence: 20 byte times, at least 5 ms. UARTs alone would allow two byte times, but a host behind a USB adapter
/// pauses inside a frame for as long as its operating system likes, and the manuals name no limit.
///
/// Two talkers at once: a byte that begins while another is on the line becomes one with it, the AND of both (a driven
/// 0 wins). So two devices with one id that answer alike in the same instant are heard as one.
///
/// Single-threaded, driven by events, no heap after the last `attach`.
class SerialWire
{
public:
    static constexpr std::size_t host_capacity = 4096;
    static constexpr std::size_t station_capacity = 256; ///< an answer that does not fit is not given

    explicit SerialWire(Duplex duplex) : duplex_(duplex) {}

    /// The station must outlive the wire.
    void attach(Station& station);
    /// Who hears the devices; nullptr: nobody. It must stay until another one, or nobody, takes its place.
    void connect(SerialHost* host) { host_ = host; }

    /// The host sends from `now` on, or when the bytes before these are out; they keep the rate given here. Returns how
    /// many fit. The wire has been run until `now`. At rate 0 nothing goes out and the bytes are lost.
    std::size_t host_sends(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate, TimePoint now);
    std::size_t host_room() const { return host_out_.room(); }

    /// `TimePoint::max()`: nothing will happen until the host sends.
    TimePoint next_event() const;
    /// All events up to `until` and at it, in the order of time.
    void run_until(TimePoint until);

private:
    struct Connection {
        explicit Connection(Station& s) : station(&s), out(station_capacity) {}
        Station* station;
        Transmitter out;
        Receiver in;
        TimePoint gives_up = TimePoint::max();
        bool answering = false;
    };

    /// One direction of the wire, or the whole of it on half duplex. The byte on it, if it is busy.
    struct Line {
        bool busy = false;
        Transmitter::Byte byte{};
        TimePoint next_event() const { return busy ? byte.end : TimePoint::max(); }
    };

    Line& from_host() { return lines_[0]; }
    Line& from_stations() { return lines_[duplex_ == Duplex::full ? 1 : 0]; }
    void step(TimePoint at);
    void finish(Line& line);
    static void start(Transmitter& transmitter, Line& line);
    static void hear(Connection& connection, const Transmitter::Byte& byte);
    static void find_requests(Connection& connection, bool silent, TimePoint at);

    Duplex duplex_;
    SerialHost* host_ = nullptr;
    Transmitter host_out_{host_capacity};
    std::vector<Connection> connections_;
    Line lines_[2];
};

} // namespace sinew::sim
