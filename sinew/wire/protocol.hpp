#pragma once
#include "sinew/wire/frame.hpp"
#include "sinew/wire/profile.hpp"
#include "sinew/wire/request.hpp"
#include "sinew/wire/row.hpp"

#include <cstdint>
#include <span>
#include <string_view>

namespace sinew::wire {

/// Where the next frame of a byte stream stands: after `skip` bytes of garbage, `size` bytes long. Size 0: what follows
/// the garbage is not a frame yet; come back with more bytes, or when the line has fallen silent.
struct Scan {
    std::size_t skip = 0;
    std::size_t size = 0;
    bool bad_checksum = false; ///< something in the garbage is a frame but for its checksum
};

/// Framing and matching of one family, for both ends of the wire. Stateless, without I/O, time or heap: the caller
/// keeps the bytes, drops `skip + size` of them after each scan, and any split of a stream gives the same frames.
class Protocol
{
public:
    virtual ~Protocol() = default;

    /// The next request in what a device hears. `silent`: the line has been quiet for longer than a frame may pause, so
    /// a frame that is not complete never will be.
    virtual Scan find_request(std::span<const std::uint8_t> bytes, bool silent) const = 0;

    /// The next reply in what a host hears. `awaited` is the size of the reply that is due; only families whose replies
    /// carry no framing of their own need it.
    virtual Scan find_reply(std::span<const std::uint8_t> bytes, std::size_t awaited, bool silent) const = 0;

    /// The message of `profile` that a frame is, by its selecting bytes alone; nullptr: none. Families whose replies
    /// carry nothing to tell them by know requests only.
    virtual const MessageInfo* identify(const Frame& frame, Direction direction, const Profile& profile) const = 0;

    /// The id that a request frame is for; -1: for several, for nobody, or not to be told. So a wire with many devices
    /// need not ask each of them.
    virtual int addressee(const Frame& request) const = 0;

    /// Whether `reply` can be the answer to the request `asked` of message `message`: address and message fit.
    virtual bool answers(const Frame& asked, const MessageInfo& message, const Frame& reply, Options options) const = 0;

    /// Whether `reply`, as all that was heard, is that answer: what `find_reply` and then `answers` say, in one step.
    /// Its bytes that are not in use are 0.
    virtual bool is_answer(const Frame& asked, const MessageInfo& message, const Frame& reply, Options options) const
    {
        const Scan scan = find_reply(reply.bytes(), reply.size, false);
        return scan.skip == 0 && scan.size == reply.size && answers(asked, message, reply, options);
    }

    /// A read that every device of the family answers, and whose answer names the device: for scans, and to find out
    /// whether a line can be trusted again. `bad_id` when the family has no such id.
    virtual std::expected<Request, Error> probe(int id) const = 0;

    /// Replies carry nothing to tell them by, so a late one can be taken for the answer to another request.
    virtual bool bare_replies() const { return false; }
};

} // namespace sinew::wire
