#pragma once
#include "sinew/wire/protocol.hpp"

#include <array>

namespace sinew::nuri
{

/// Nuri on the wire: FF FE, id, size, checksum, mode, payload. Nothing is escaped and FF FE can stand inside a payload
/// (N26), so a frame is found by its size and checksum; only where those fail the search goes on one byte later. The
/// size must be one that the mode has.
const wire::Protocol& protocol();

/// The same for another firmware line, whose modes have other sizes. `messages` must live as long as the program.
class Framing final : public wire::Protocol
{
public:
    explicit constexpr Framing(std::span<const wire::MessageInfo* const> messages);

    wire::Scan find_request(std::span<const std::uint8_t> bytes, bool silent) const override;
    wire::Scan find_reply(std::span<const std::uint8_t> bytes, std::size_t awaited, bool silent) const override;
    const wire::MessageInfo* identify(const wire::Frame& frame, wire::Direction direction,
                                      const wire::Profile& profile) const override;
    bool answers(const wire::Frame& asked, const wire::MessageInfo& message, const wire::Frame& reply,
                 wire::Options options) const override;
    std::expected<wire::Request, Error> probe(int id) const override;

private:
    std::array<std::uint8_t, 256> sizes_{}; ///< whole frame by mode; 0: the mode is not known
};

constexpr Framing::Framing(std::span<const wire::MessageInfo* const> messages)
{
    for (const auto* message : messages)
        for (const auto* side : {&message->request, &message->reply})
            if (side->exists())
                sizes_[static_cast<std::size_t>(side->opcode)] = side->size;
}

} // namespace sinew::nuri
