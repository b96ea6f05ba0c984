#pragma once
#include "sinew/bus/bus.hpp"
#include "sinew/diagnosis/audience.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

/// One link that is looked at with one question after the other, whatever the family and the bit rate.
namespace sinew::diagnosis {

/// One request and what came of it.
struct Look {
    std::optional<wire::Frame> reply;
    Duration round_trip{};
    Duration excess{};               ///< of the round trip, beyond what bits and device take
    bool noise = false;              ///< something was heard that is no answer to it
    std::vector<std::uint8_t> heard; ///< the first bytes, as they came
    Error error{};                   ///< of a look without an answer
};

/// Several requests at once and what came of each.
struct Looks {
    std::vector<bus::Result> results;
    bool noise = false; ///< something was heard that is no answer to any of them
};

/// Owns the link. A look is an exchange of its own that remembers nothing: what comes late is noise in the next one.
/// One thread. Fails only when the link is lost.
class Line
{
public:
    /// The clock must outlive the line.
    Line(link::AnyLink link, link::Clock& clock);
    ~Line();
    Line(const Line&) = delete;
    Line& operator=(const Line&) = delete;

    bool can() const;
    link::LinkState state() const;
    std::uint32_t bit_rate() const { return state().bit_rate; }
    link::Clock& clock() const { return clock_; }
    const link::AnyLink& link() const; ///< to look at

    /// Asks an SLCAN adapter for its flags, which it forgets by that; nothing where there is none, or no answer.
    std::expected<std::optional<std::uint8_t>, Error> adapter_flags();

    /// A rate that the link cannot have is false, and leaves the old one.
    std::expected<bool, Error> set_bit_rate(std::uint32_t rate);
    /// From now on what the adapter hears of itself is swallowed. Serial lines only.
    void swallow_echo();

    /// The first of the ways that nobody who hears it can take for more than a read; on CAN all hear at one rate, and
    /// it is simply the first. Where somebody at another rate waits for the rest of what he takes for a message, and
    /// every way would end it, a single byte that harms nobody goes out before. Nothing when there is no way.
    std::optional<wire::Request> safe_one(std::span<const wire::Request> ways);

    /// Sends one request, as `safe_one` gave it. The first byte of an answer may come as long as `wait` after the last
    /// bit of the request; once something was heard, the rest of it may take as long again.
    std::expected<Look, Error> look(const wire::Request& request, const Family& family, Duration wait);
    /// All requests at once, for CAN.
    std::expected<Looks, Error> look_at_all(std::span<const wire::Request> requests, const Family& family,
                                            Duration wait);
    /// Sends nothing. Bytes, or frames in the order in which they came.
    std::expected<std::vector<wire::Frame>, Error> listen(Duration how_long);

private:
    struct Shared;
    bool send_filler(std::uint8_t byte);
    std::unique_ptr<bus::Bus> make_bus(const Family& family, Duration wait);

    std::unique_ptr<Shared> shared_;
    link::Clock& clock_;
    Audience audience_;
    TimePoint filled_until_{}; ///< the bytes that went out before a question have left by then
};

/// How long a look without an answer takes: the request, the wait, and the byte that it is for.
Duration time_of_look(const wire::Request& request, const Family& family, std::uint32_t bit_rate, Duration wait);

} // namespace sinew::diagnosis
