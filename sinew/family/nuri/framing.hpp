#pragma once
#include "sinew/wire/protocol.hpp"

#include <array>
#include <initializer_list>

namespace sinew::nuri {

/// Nuri on the wire: FF FE, id, size, checksum, mode, payload. Nothing is escaped and FF FE can stand inside a payload
/// (N26), so a frame is found by its size and checksum; only where those fail the search goes on one byte later. The
/// size must be one that the mode has on one of the firmware lines.
const wire::Protocol& protocol();

/// The same for given lists of messages.
class Framing final : public wire::Protocol
{
public:
    explicit constexpr Framing(std::initializer_list<std::span<const wire::MessageInfo* const>> lines);

    wire::Scan find_request(std::span<const std::uint8_t> bytes, bool silent) const override;
    wire::Scan find_reply(std::span<const std::uint8_t> bytes, std::size_t awaited, bool silent) const override;
    const wire::MessageInfo* identify(const wire::Frame& frame, wire::Direction direction,
                                      const wire::Profile& profile) const override;
    int addressee(const wire::Frame& request) const override;
    bool answers(const wire::Frame& asked, const wire::MessageInfo& message, const wire::Frame& reply,
                 wire::Options options) const override;
    bool is_answer(const wire::Frame& asked, const wire::MessageInfo& message, const wire::Frame& reply,
                   wire::Options options) const override;
    std::expected<wire::Request, Error> probe(int id) const override;

private:
    std::array<std::uint16_t, 256> sizes_{}; ///< by mode: bit n for a whole frame of n bytes; 0: the mode is not known
};

constexpr Framing::Framing(std::initializer_list<std::span<const wire::MessageInfo* const>> lines)
{
    for (const auto& messages : lines)
        for (const auto* message : messages)
            for (const auto* side : {&message->request, &message->reply})
                if (side->exists()) {
                    auto& sizes = sizes_[static_cast<std::size_t>(side->opcode)];
                    sizes = static_cast<std::uint16_t>(sizes | 1U << side->size);
                }
}

} // namespace sinew::nuri
