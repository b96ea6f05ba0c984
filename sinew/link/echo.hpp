#pragma once
#include "sinew/link/link.hpp"
#include "sinew/link/uri.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace sinew::link {

/// Option `echo=on|off` of a link, off where it is not given.
std::expected<bool, Error> echo_option(const Uri& uri);

/// A byte link over an adapter that hears itself (RS-485 with the receiver always on): what comes back of the own bytes
/// is swallowed. Bytes that match what was written are held back until the whole of it is heard; at the first byte that
/// differs everything held back and everything after it is passed on, and nothing more is expected to echo until the
/// next write. So an adapter without echo works as well, as long as no answer begins with the whole request.
class EchoLink final : public ByteLink
{
public:
    explicit EchoLink(std::unique_ptr<ByteLink> inner) : inner_(std::move(inner)) {}

    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        const auto count = inner_->write(bytes.first(std::min(bytes.size(), capacity - expected_.size())));
        if (count)
            expected_.append(bytes.first(*count));
        return count;
    }

    std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override
    {
        if (passed_.empty()) {
            // All that is held back may come out together with what is read now; beyond that nothing is left in here
            // that the caller, who waits for the handle, would not hear of.
            std::array<std::uint8_t, capacity> heard;
            const auto arrival = inner_->read(std::span(heard).first(std::min(into.size(), capacity - matched_)));
            if (!arrival)
                return arrival;
            at_ = arrival->at;
            for (std::size_t i = 0; i < arrival->count; ++i)
                hear(heard[i]);
        }
        const std::size_t count = std::min(into.size(), passed_.size());
        std::ranges::copy(passed_.bytes().first(count), into.begin());
        passed_.drop(count);
        return Arrival{.count = count, .at = at_};
    }

    int handle() const override { return inner_->handle(); }
    LinkState state() const override { return inner_->state(); }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override
    {
        return inner_->set_bit_rate(bit_rate);
    }

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

    private:
        std::array<std::uint8_t, capacity> data_{};
        std::size_t size_ = 0;
    };

    void hear(std::uint8_t byte)
    {
        if (expected_.empty()) {
            passed_.append({&byte, 1});
        } else if (byte == expected_.bytes()[matched_]) {
            if (++matched_ == expected_.size())
                forget();
        } else {
            passed_.append(expected_.bytes().first(matched_));
            passed_.append({&byte, 1});
            forget();
        }
    }

    void forget()
    {
        expected_.drop(expected_.size());
        matched_ = 0;
    }

    std::unique_ptr<ByteLink> inner_;
    Buffer expected_; ///< written and not yet heard
    Buffer passed_;   ///< heard and not the own
    std::size_t matched_ = 0;
    TimePoint at_{};
};

} // namespace sinew::link
