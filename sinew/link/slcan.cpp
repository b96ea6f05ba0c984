#include "sinew/link/slcan.hpp"

#include "sinew/link/can_frames.hpp"
#include "sinew/link/serial.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::link {
namespace {

using std::chrono::milliseconds;

/// An adapter that answers does so within a USB frame or two; one that is silent costs this much at each command.
constexpr Duration answer_limit = milliseconds{100};
/// A line is over when nothing came for this long.
constexpr Duration silence = milliseconds{20};

std::span<const std::uint8_t> bytes(std::string_view text)
{
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::unexpected<Error> refuse_rate(std::uint32_t bit_rate)
{
    return fail(Errc::unsupported, fmt::format("SLCAN has no code for {} bit/s on CAN; it has {}", bit_rate,
                                               fmt::join(slcan::bit_rates, ", ")));
}

/// The conversation at the start, where waiting is allowed.
class Opening
{
public:
    Opening(ByteLink& adapter, Clock& clock) : adapter_(adapter), clock_(clock) {}

    std::expected<void, Error> close_what_is_open()
    {
        // The first CR ends what another program may have left half written.
        if (const auto sent = send("\rC\r"); !sent)
            return sent;
        const TimePoint deadline = clock_.now() + answer_limit;
        for (;;) {
            const auto count = hear(std::min(clock_.now() + silence, deadline));
            if (!count)
                return std::unexpected(count.error());
            if (*count == 0 || clock_.now() >= deadline)
                return {};
        }
    }

    /// Sends and waits for the acknowledgement.
    std::expected<void, Error> command(std::string_view text, std::string_view refusal)
    {
        if (const auto sent = send(text); !sent)
            return sent;
        slcan::Reader reader;
        const TimePoint deadline = clock_.now() + answer_limit;
        for (;;) {
            const auto count = hear(deadline);
            if (!count)
                return std::unexpected(count.error());
            if (*count == 0)
                return {};
            for (const std::uint8_t byte : std::span(heard_).first(*count)) {
                const auto end = reader.take(byte);
                if (end == slcan::Reader::End::refused)
                    return fail(Errc::link_failed, std::string{refusal});
                if (end == slcan::Reader::End::line && reader.text().empty())
                    return {};
            }
        }
    }

private:
    std::expected<void, Error> send(std::string_view text)
    {
        const TimePoint deadline = clock_.now() + answer_limit;
        auto rest = bytes(text);
        for (;;) {
            const auto count = adapter_.write(rest);
            if (!count)
                return std::unexpected(count.error());
            rest = rest.subspan(*count);
            if (rest.empty())
                return {};
            if (clock_.now() >= deadline)
                return fail(Errc::link_failed, "the SLCAN adapter takes no bytes; unplug it and plug it in again");
            const Handle handles[] = {{.fd = adapter_.handle(), .wants_write = true}};
            clock_.wait(handles, deadline);
        }
    }

    /// How many bytes came until the deadline, at the first that came.
    std::expected<std::size_t, Error> hear(TimePoint deadline)
    {
        for (;;) {
            const auto arrival = adapter_.read(heard_);
            if (!arrival)
                return std::unexpected(arrival.error());
            if (arrival->count != 0 || clock_.now() >= deadline)
                return arrival->count;
            const Handle handles[] = {{.fd = adapter_.handle()}};
            clock_.wait(handles, deadline);
        }
    }

    ByteLink& adapter_;
    Clock& clock_;
    std::array<std::uint8_t, 256> heard_{};
};

} // namespace

std::expected<std::unique_ptr<CanLink>, Error> SlcanLink::open(std::unique_ptr<ByteLink> adapter,
                                                               std::uint32_t bit_rate, Clock& clock)
{
    const auto code = slcan::code_of(bit_rate);
    if (!code)
        return refuse_rate(bit_rate);
    Opening opening{*adapter, clock};
    if (const auto closed = opening.close_what_is_open(); !closed)
        return std::unexpected(closed.error());
    const char rate[] = {'S', *code, slcan::end_of_line};
    if (const auto set = opening.command(
            {rate, sizeof rate}, fmt::format("the SLCAN adapter refuses {} bit/s; is it an SLCAN adapter?", bit_rate));
        !set)
        return std::unexpected(set.error());
    if (const auto opened =
            opening.command("O\r", "the SLCAN adapter refuses to open its CAN bus; unplug it and plug it in again");
        !opened)
        return std::unexpected(opened.error());
    return std::unique_ptr<CanLink>(new SlcanLink(std::move(adapter), bit_rate));
}

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
        asked_flags_ = false;
        knows_flags_ = true;
        counters_.overruns += (flags_ & (slcan::flag::overrun | slcan::flag::receive_queue_full)) != 0 ? 1 : 0;
    }
    const slcan::Line line = slcan::decode(text);
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
        return refuse_rate(bit_rate);
    const std::array<char, 7> text = {'C', '\r', 'S', *code, '\r', 'O', '\r'};
    if (const auto sent = send(); !sent)
        return std::unexpected(sent.error());
    if (room() < text.size())
        return fail(Errc::link_failed, "the SLCAN adapter takes no bytes; unplug it and plug it in again");
    queue(bytes({text.data(), text.size()}));
    if (const auto sent = send(); !sent)
        return std::unexpected(sent.error());
    return bit_rate_ = bit_rate;
}

std::expected<std::unique_ptr<CanLink>, Error> open_slcan(const Uri& uri, Clock& clock)
{
    const auto bit_rate = uri.number("bitrate");
    if (!bit_rate)
        return std::unexpected(bit_rate.error());
    const auto baud = uri.number("baud");
    if (!baud)
        return std::unexpected(baud.error());
    const std::uint32_t rate = bit_rate->value_or(1'000'000);
    if (!slcan::code_of(rate))
        return fail(Errc::bad_uri,
                    fmt::format("option bitrate must be one of {}, not {}", fmt::join(slcan::bit_rates, ", "), rate));
    auto adapter = open_serial({.device = uri.target, .bit_rate = baud->value_or(115'200)}, clock);
    if (!adapter)
        return std::unexpected(adapter.error());
    return SlcanLink::open(std::move(*adapter), rate, clock);
}

} // namespace sinew::link
