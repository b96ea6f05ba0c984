#pragma once
#include "sinew/link/slcan_codec.hpp"

#include <algorithm>

namespace sinew::link {

/// The device end of SLCAN: behaves like a LAWICEL CANUSB towards a host program and hands its frames to a simulated
/// CAN bus. Pure: bytes in, bytes out; whoever owns it moves them (behind a `PtyMaster`, say).
///
/// Commands are acknowledged with CR or refused with BEL as the LAWICEL manual has it: S only while closed, O only once
/// a rate was set, t only while open and not listening. `s` (a rate as register values of its chip) is acknowledged,
/// and the rate counts as unknown. F tells what was noted since the last F, and forgets it. Filters (M, m) are
/// acknowledged and every frame is passed all the same. Extended and remote frames are acknowledged as sent and go
/// nowhere. Time stamps are refused (Z1).
class SlcanAdapter
{
public:
    /// Takes bytes from the host. `on_frame(const wire::Frame&)` is called for each frame that goes to the bus and says
    /// whether the bus takes it; a frame that it does not take is refused, and the transmit queue counts as full.
    template <class OnFrame>
    void take(std::span<const std::uint8_t> bytes, OnFrame&& on_frame)
    {
        for (const std::uint8_t byte : bytes) {
            const auto end = reader_.take(byte);
            if (end == slcan::Reader::End::none)
                continue;
            const auto frame = end == slcan::Reader::End::line ? obey(reader_.text()) : refuse();
            if (frame)
                acknowledge(on_frame(*frame));
        }
    }

    /// A frame from the bus for the host; false when it is dropped: closed, or the host does not fetch its bytes, which
    /// counts as a receive queue that is full.
    bool offer(const wire::Frame& frame);

    /// Something that the host learns by F, once (`slcan::flag`).
    void note(std::uint8_t flags) { flags_ |= flags; }

    /// Bytes for the host, in order; `drop` those that it took.
    std::span<const std::uint8_t> pending() const { return std::span(pending_).first(size_); }
    void drop(std::size_t count);

    bool is_open() const { return mode_ != Mode::closed; }
    /// Of the CAN bus as the host chose it; 0 when it did not, or by registers.
    std::uint32_t bit_rate() const { return bit_rate_; }
    /// Back to the state after power-on: closed, no rate. Bytes that are pending are gone.
    void reset() { *this = SlcanAdapter{}; }

private:
    enum class Mode : std::uint8_t { closed, open, listening };

    /// Acts on one line and answers it; what comes back is for the bus.
    std::optional<wire::Frame> obey(std::string_view line);
    std::optional<wire::Frame> transmit(std::string_view line);
    std::optional<wire::Frame> tell_flags();
    void acknowledge(bool is_taken);
    std::optional<wire::Frame> refuse();
    std::optional<wire::Frame> answer(std::string_view text);
    std::optional<wire::Frame> answer_if(bool allowed) { return allowed ? answer("\r") : refuse(); }
    bool set_bit_rate(std::string_view code);
    bool put(std::span<const std::uint8_t> bytes);

    slcan::Reader reader_;
    Mode mode_ = Mode::closed;
    bool has_rate_ = false;
    std::uint32_t bit_rate_ = 0;
    std::uint8_t flags_ = 0;
    std::array<std::uint8_t, 4096> pending_{};
    std::size_t size_ = 0;
};

} // namespace sinew::link
