#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/slcan_codec.hpp"

namespace sinew::link {

/// An adapter that answers a command does so within a USB frame or two; one that is silent costs this much at each.
inline constexpr Duration slcan_answer_limit = std::chrono::milliseconds{100};

/// A CAN bus behind a serial adapter that speaks SLCAN (LAWICEL CANUSB, CANable and the like).
///
/// What an adapter refuses (BEL) cannot be told apart by frame, for nothing in the protocol numbers them: the next
/// `write()` says `link_failed`, once, after its frames have gone out. Meanwhile the adapter is asked for its flags (F)
/// once, and what it answers stands in the sentence; one that does not know the command is not asked again. Frames with
/// extended identifiers and remote requests of others are counted and dropped. The link is closed on the adapter too
/// when this object goes.
class SlcanLink final : public CanLink
{
public:
    /// What the adapter did to us since the start.
    struct Counters {
        std::uint64_t refused = 0;   ///< BELs
        std::uint64_t malformed = 0; ///< lines that were no line of the protocol
        std::uint64_t foreign = 0;   ///< extended or remote frames
        std::uint64_t overruns = 0;  ///< answers by which frames were lost in the adapter
    };

    /// Closes whatever a program before left open, sets the CAN bit rate and opens. Takes up to 0.4 s: some adapters
    /// never acknowledge anything, and silence is taken for yes. `unsupported` for a rate that SLCAN has no code for,
    /// `link_failed` when the adapter refuses. The clock must be the one of `adapter`.
    static std::expected<std::unique_ptr<CanLink>, Error> open(std::unique_ptr<ByteLink> adapter,
                                                               std::uint32_t bit_rate, Clock& clock);
    ~SlcanLink() override;

    /// Takes frames while their text fits into 1 KiB that waits for the adapter. `out_of_range` for an identifier above
    /// 0x7FF, `bad_length` for more than 8 bytes; then nothing is queued.
    std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) override;
    /// `at` is the arrival of the bytes that completed the last frame.
    std::expected<Arrival, Error> read(std::span<wire::Frame> into) override;
    int handle() const override { return adapter_->handle(); }
    /// Whether text still waits for the adapter to take it; both `write` and `read` go on with it.
    bool wants_write() const { return unsent_size_ != 0; }
    /// `bit_rate` is that of the CAN bus.
    LinkState state() const override { return {.open = adapter_->state().open, .bit_rate = bit_rate_}; }
    /// Closes the bus for a moment. Does not wait for the adapter: a refusal shows in the next `write`.
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override;

    std::size_t spell(const wire::Frame& frame, std::span<std::uint8_t, longest_spelling> into) const override;

    const Counters& counters() const { return counters_; }
    /// Asks the adapter for its flags, which it forgets by that; a later `read` brings the answer to `flags()`. False
    /// while an answer is due, and for an adapter that does not know the command.
    bool ask_flags();
    /// The latest answer (`slcan::flag`).
    std::uint8_t flags() const { return flags_; }
    bool flags_are_due() const { return asked_flags_; }
    std::uint64_t flags_told() const { return flags_told_; } ///< answers so far
    /// Whether the adapter has said anything at all of what the protocol has, at the opening or since. One that has not
    /// may be an adapter that never acknowledges, or none.
    bool has_answered() const { return has_answered_; }

private:
    friend class SlcanReopening;
    SlcanLink(std::unique_ptr<ByteLink> adapter, std::uint32_t bit_rate, bool has_answered,
              const slcan::Reader& reader = {})
        : adapter_(std::move(adapter)), bit_rate_(bit_rate), has_answered_(has_answered), reader_(reader)
    {
    }
    std::expected<void, Error> send();
    std::size_t room() const { return unsent_.size() - unsent_size_; }
    void queue(std::span<const std::uint8_t> text);
    std::optional<wire::Frame> take(std::uint8_t byte);
    std::optional<wire::Frame> take_line(std::string_view text);
    void take_refusal();

    std::unique_ptr<ByteLink> adapter_;
    std::uint32_t bit_rate_;
    bool has_answered_;
    Counters counters_;
    std::uint64_t reported_ = 0; ///< of the refusals
    std::uint8_t flags_ = 0;
    std::uint64_t flags_told_ = 0;
    bool wants_flags_ = false; ///< of the adapter, for it refused something
    bool asked_flags_ = false; ///< and the answer is due
    bool knows_flags_ = true;
    slcan::Reader reader_;
    std::array<std::uint8_t, 1024> unsent_{};
    std::size_t unsent_size_ = 0;
    std::array<std::uint8_t, 256> heard_{};
    std::span<const std::uint8_t> unread_; ///< the part of `heard_` that is still to be looked at
    TimePoint heard_at_{};
};

/// An adapter is asked for its flags, and somebody reads its link until `is_over`.
class FlagsQuestion
{
public:
    FlagsQuestion(SlcanLink& adapter, TimePoint now)
        : before_(adapter.flags_told()), until_(now + slcan_answer_limit),
          is_open_(adapter.ask_flags() || adapter.flags_are_due())
    {
    }
    /// False for an adapter that seems not to know the command: whoever asks often does not wait for it. It may answer
    /// all the same, for what looked like its refusal may have been that of a frame before.
    bool is_open() const { return is_open_; }
    TimePoint until() const { return until_; }
    bool is_answered(const SlcanLink& adapter) const { return adapter.flags_told() != before_; }
    bool is_over(const SlcanLink& adapter, TimePoint now) const { return is_answered(adapter) || now >= until_; }

private:
    std::uint64_t before_;
    TimePoint until_;
    bool is_open_;
};

} // namespace sinew::link
