#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/uri.hpp"

#include <algorithm>
#include <array>
#include <memory>

namespace sinew::link {

/// Whether an adapter hears itself (RS-485 with the receiver always on).
enum class Echo : std::uint8_t {
    off,
    on,
    automatic, ///< not known: the traffic tells
};

/// Option `echo=on|off|auto` of a link, off where it is not given.
std::expected<Echo, Error> echo_option(const Uri& uri);

/// A byte link over an adapter that hears itself, or may do so: what comes back of the own bytes is swallowed.
///
/// Where there is an echo, nothing passes after a write until all that was written has been heard: what comes before
/// cannot be the answer, and an echo that is damaged means that the request was. So an answer after a damaged echo is
/// lost, and never is a piece of an echo taken for one.
///
/// With `automatic` nothing is sent to find out. The first whole echo decides that there is one. Bytes that no echo
/// with one byte flipped, lost or added explains pass at once; three writes without an echo decide that there is
/// none, and from then on everything passes untouched. Until then an answer that looks like the beginning of its own
/// request is held back, and dropped at the next write. Where a device repeats a whole request as its answer, the
/// option must be given as on or off.
class EchoLink final : public ByteLink
{
public:
    /// `echo` is not `off`. The clock, that of `inner`, must outlive the link.
    EchoLink(std::unique_ptr<ByteLink> inner, Echo echo, const Clock& clock);

    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override;
    std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override;
    int handle() const override { return inner_->handle(); }
    LinkState state() const override { return inner_->state(); }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override
    {
        return inner_->set_bit_rate(bit_rate);
    }

    Echo echo() const { return echo_; } ///< `automatic`: not decided yet

    /// An echo that has not come so long after its own bits does not come: adapters keep bytes back for 16 ms at most.
    static constexpr Duration patience = std::chrono::milliseconds{25};
    static constexpr int writes_to_decide = 3;

private:
    static constexpr std::size_t capacity = 512;

    class Buffer
    {
    public:
        std::size_t size() const { return size_; }
        bool empty() const { return size_ == 0; }
        std::span<const std::uint8_t> bytes() const { return std::span(data_).first(size_); }
        void append(std::span<const std::uint8_t> bytes)
        {
            std::ranges::copy(bytes, data_.begin() + size_);
            size_ += bytes.size();
        }
        void drop(std::size_t count)
        {
            std::copy(data_.begin() + count, data_.begin() + size_, data_.begin());
            size_ -= count;
        }
        void clear() { size_ = 0; }

    private:
        std::array<std::uint8_t, capacity> data_{};
        std::size_t size_ = 0;
    };

    bool given_up(TimePoint now) const;
    void hear(std::uint8_t byte);
    void hear_where_an_echo_is(std::uint8_t byte);
    void hear_where_an_echo_may_be(std::uint8_t byte);
    void found_no_echo();
    void forget();

    std::unique_ptr<ByteLink> inner_;
    Echo echo_;
    const Clock* clock_;
    Buffer expected_; ///< written and not yet heard
    Buffer heard_;    ///< since then, and not passed
    Buffer passed_;   ///< for the reader
    bool damaged_ = false;
    int unechoed_ = 0; ///< writes
    TimePoint written_at_{};
    TimePoint at_{};
};

/// The link itself where there is no echo.
std::unique_ptr<ByteLink> with_echo(std::unique_ptr<ByteLink> link, Echo echo, const Clock& clock);

} // namespace sinew::link
