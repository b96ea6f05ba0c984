#include "sinew/link/slcan.hpp"

#include "sinew/link/can_frames.hpp"
#include "sinew/link/slcan_opening.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::link {
namespace {

std::span<const std::uint8_t> bytes(std::string_view text)
{
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

} // namespace

std::size_t SlcanLink::spell(const wire::Frame& frame, std::span<std::uint8_t, longest_spelling> into) const
{
    return slcan::encode(frame, into.first<slcan::longest_frame_text>());
}

SlcanLink::~SlcanLink()
{
    // What is unsent ends in the middle of a line, and only as much as fits can go: nothing waits any more.
    if (send() && unsent_size_ == 0)
        static_cast<void>(adapter_->write(bytes("C\r")));
}

std::expected<void, Error> SlcanLink::send()
{
    const auto count = adapter_->write(std::span(unsent_).first(unsent_size_));
    if (!count)
        return std::unexpected(count.error());
    std::copy(unsent_.begin() + *count, unsent_.begin() + unsent_size_, unsent_.begin());
    unsent_size_ -= *count;
    return {};
}

void SlcanLink::queue(std::span<const std::uint8_t> text)
{
    std::ranges::copy(text, unsent_.begin() + unsent_size_);
    unsent_size_ += text.size();
}

std::expected<std::size_t, Error> SlcanLink::write(std::span<const wire::Frame> frames)
{
    if (const auto fine = check_can_frames(frames); !fine)
        return std::unexpected(fine.error());
    if (const auto sent = send(); !sent)
        return std::unexpected(sent.error());
    std::size_t taken = 0;
    for (const wire::Frame& frame : frames) {
        std::array<std::uint8_t, slcan::longest_frame_text> text;
        const std::size_t size = slcan::encode(frame, text);
        if (size > room())
            break;
        queue(std::span(text).first(size));
        ++taken;
    }
    if (const auto sent = send(); !sent)
        return std::unexpected(sent.error());
    // Only now: these frames must not be lost to the refusal of an earlier one.
    if (counters_.refused != reported_) {
        reported_ = counters_.refused;
        const std::string why = slcan::to_words(flags_);
        return fail(Errc::link_failed, fmt::format("the SLCAN adapter refused a command or frame (BEL){}{}; does the "
                                                   "bus have power, termination and its rate?",
                                                   why.empty() ? "" : " and reports ", why));
    }
    return taken;
}

std::expected<Arrival, Error> SlcanLink::read(std::span<wire::Frame> into)
{
    if (unsent_size_ != 0)
        if (const auto sent = send(); !sent)
            return std::unexpected(sent.error());
    std::size_t count = 0;
    TimePoint at{};
    while (count < into.size()) {
        if (unread_.empty()) {
            const auto arrival = adapter_->read(heard_);
            if (!arrival && count == 0)
                return std::unexpected(arrival.error());
            if (!arrival || arrival->count == 0)
                break;
            unread_ = std::span(heard_).first(arrival->count);
            heard_at_ = arrival->at;
        }
        const std::uint8_t byte = unread_.front();
        unread_ = unread_.subspan(1);
        if (const auto frame = take(byte)) {
            into[count++] = *frame;
            at = heard_at_;
        }
    }
    if (wants_flags_ && ask_flags())
        if (const auto sent = send(); !sent && count == 0)
            return std::unexpected(sent.error());
    return Arrival{.count = count, .at = at};
}

bool SlcanLink::ask_flags()
{
    constexpr std::string_view question = "F\r";
    wants_flags_ = false;
    if (!knows_flags_ || asked_flags_ || room() < question.size())
        return false;
    queue(bytes(question));
    asked_flags_ = true;
    return true;
}

/// A refusal while the flags are due answers that question.
void SlcanLink::take_refusal()
{
    if (asked_flags_) {
        asked_flags_ = knows_flags_ = false;
        return;
    }
    ++counters_.refused;
    wants_flags_ = true;
}

std::optional<wire::Frame> SlcanLink::take(std::uint8_t byte)
{
    switch (reader_.take(byte)) {
    case slcan::Reader::End::none:
        return std::nullopt;
    case slcan::Reader::End::refused:
        has_answered_ = true;
        take_refusal();
        return std::nullopt;
    case slcan::Reader::End::overlong:
        ++counters_.malformed;
        return std::nullopt;
    case slcan::Reader::End::line:
        return take_line(reader_.text());
    }
    return std::nullopt;
}

std::optional<wire::Frame> SlcanLink::take_line(std::string_view text)
{
    if (const auto flags = slcan::decode_flags(text)) {
        flags_ = *flags;
        ++flags_told_;
        asked_flags_ = false;
        has_answered_ = knows_flags_ = true;
        counters_.overruns += (flags_ & (slcan::flag::overrun | slcan::flag::receive_queue_full)) != 0 ? 1 : 0;
    }
    const slcan::Line line = slcan::decode(text);
    has_answered_ |= line.kind == slcan::Kind::frame || text.empty() || text == "z" || text == "Z";
    switch (line.kind) {
    case slcan::Kind::frame:
        return line.frame;
    case slcan::Kind::foreign:
        ++counters_.foreign;
        break;
    case slcan::Kind::malformed:
        ++counters_.malformed;
        break;
    case slcan::Kind::other:
        break;
    }
    return std::nullopt;
}

std::expected<std::uint32_t, Error> SlcanLink::set_bit_rate(std::uint32_t bit_rate)
{
    const auto code = slcan::code_of(bit_rate);
    if (!code)
        return refuse_slcan_rate(bit_rate);
    const std::array<char, 7> text = {'C', '\r', 'S', *code, '\r', 'O', '\r'};
    if (const auto sent = send(); !sent)
        return std::unexpected(sent.error());
    if (room() < text.size())
        return slcan_takes_no_bytes();
    queue(bytes({text.data(), text.size()}));
    if (const auto sent = send(); !sent)
        return std::unexpected(sent.error());
    return bit_rate_ = bit_rate;
}

} // namespace sinew::link
