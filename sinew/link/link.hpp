#pragma once
#include "sinew/base/error.hpp"
#include "sinew/base/time.hpp"
#include "sinew/wire/frame.hpp"

#include <cstdint>
#include <expected>
#include <memory>
#include <span>
#include <variant>

/// Links move bytes or CAN frames between this program and a wire; they know no protocol.
namespace sinew::link {

struct LinkState {
    bool open = false;          ///< false: hung up; the descriptor is closed and the link stays lost
    std::uint32_t bit_rate = 0; ///< bits per second on the wire as really set; 0 where the link cannot know (TCP)
};

/// What one read brought: how much, and when it arrived (the end of the last byte or frame as the clock of the link saw
/// it).
struct Arrival {
    std::size_t count = 0;
    TimePoint at{};    ///< of no meaning where `count` is 0
    bool more = false; ///< read again before waiting: there is more, or finding that out costs no system call; also
                       ///< when `count` is all that was asked for
};

/// A line of bytes. No call blocks. After `link_lost` every call fails with `link_lost`.
/// Owned by one bus and used from the thread that drives it.
class ByteLink
{
public:
    virtual ~ByteLink() = default;
    /// Writes what fits and says how many bytes that was.
    virtual std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) = 0;
    /// Reads what is there, into at least one byte; `count` 0: nothing yet.
    virtual std::expected<Arrival, Error> read(std::span<std::uint8_t> into) = 0;
    virtual int handle() const = 0; ///< for ppoll; -1: virtual
    virtual LinkState state() const = 0;
    /// Sets another bit rate and returns the one that was really set. `unsupported` where the link has none (TCP).
    virtual std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) = 0;
};

/// The longest form in which a descriptor takes one frame: a line of SLCAN, or all that a frame holds.
inline constexpr std::size_t longest_spelling = 32;

/// A CAN bus. No call blocks. Own frames are never read back.
class CanLink
{
public:
    virtual ~CanLink() = default;
    /// Queues as many frames as fit and says how many that was.
    virtual std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) = 0;
    virtual std::expected<Arrival, Error> read(std::span<wire::Frame> into) = 0;
    virtual int handle() const = 0;
    virtual LinkState state() const = 0;
    virtual std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) = 0;
    /// The bytes that somebody who holds the descriptor and not this object writes to it to send a frame, and how many
    /// they are; for the process that stops the motors when this one has died. 0: there is no such descriptor.
    virtual std::size_t spell(const wire::Frame&, std::span<std::uint8_t, longest_spelling>) const { return 0; }
};

/// An open link of either kind.
using AnyLink = std::variant<std::unique_ptr<ByteLink>, std::unique_ptr<CanLink>>;

} // namespace sinew::link
