#pragma once
#include "sinew/base/error.hpp"
#include "sinew/base/time.hpp"
#include "sinew/wire/frame.hpp"
#include "sinew/wire/row.hpp"

#include <chrono>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Traffic that was seen on a wire, kept in files that other tools read as well.
namespace sinew::record {

/// Time of day (UTC), nanoseconds since 1970. Of a bus in virtual time: since its power-on.
using Time = std::chrono::sys_time<Duration>;

/// What passed at one moment: a CAN frame, or bytes of a serial line as they were heard (a frame, part of one,
/// several).
struct Captured {
    enum class Kind : std::uint8_t {
        bytes,      ///< of a serial line
        can,        ///< a CAN frame with data
        can_remote, ///< a remote request: no data, `frame.size` is the length it asks for
        can_error,  ///< what SocketCAN says of the bus itself; `frame.can_id` has the error class, without the flag
    };

    Time at{};
    std::string bus;                          ///< its name; empty: not known
    std::string family;                       ///< whose frames these are; empty: not known
    std::optional<wire::Direction> direction; ///< as seen from the host; not given: the recorder could not tell
    Kind kind = Kind::bytes;
    bool extended = false;           ///< the identifier has 29 bits; no family uses those
    wire::Frame frame{};             ///< of CAN; at most 8 bytes
    std::vector<std::uint8_t> bytes; ///< of a serial line
    std::string discarded;           ///< why the host threw it away; empty: it did not

    bool is_can() const { return kind != Kind::bytes; }
    /// What it carries, whatever it is.
    std::span<const std::uint8_t> data() const
    {
        if (kind == Kind::bytes)
            return bytes;
        return kind == Kind::can_remote ? std::span<const std::uint8_t>{} : frame.bytes();
    }

    friend bool operator==(const Captured&, const Captured&) = default;
};

/// A recording as it is read, in pieces of any size. Nothing is read ahead and nothing thrown.
class Reader
{
public:
    virtual ~Reader() = default;

    /// More of the file.
    virtual void feed(std::span<const std::uint8_t> bytes) = 0;
    /// That was all of it.
    virtual void end() = 0;
    /// What comes next in the file; nothing: feed more or, after `end`, it is over. `bad_file` says where (line or
    /// offset) and what; go on asking, for what can be read after that follows. A file that is cut off gives all that
    /// stands before the cut, then the error.
    virtual std::expected<std::optional<Captured>, Error> next() = 0;
};

/// Puts frames into the words of a format. Pure: whoever uses it writes the bytes.
class Writer
{
public:
    virtual ~Writer() = default;
    /// Appends to `out` what the file needs for this one, unless the format holds it back until `flush`.
    /// `bad_argument` and nothing appended where the format cannot hold it.
    virtual std::expected<void, Error> add(const Captured& captured, std::string& out) = 0;
    /// Appends what was held back.
    virtual void flush(std::string&) {}
    /// The same, and what ends a file; nothing is added after it.
    virtual void finish(std::string&) {}
};

} // namespace sinew::record
