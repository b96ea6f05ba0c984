#include "sinew/link/slcan_opening.hpp"

#include "sinew/link/serial.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::link {
namespace {

using std::chrono::milliseconds;

/// A line is over when nothing came for this long.
constexpr Duration silence = milliseconds{20};

std::span<const std::uint8_t> bytes(std::string_view text)
{
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// What a bus is opened with: a CR that ends what may be half written, C, S and O.
constexpr std::size_t commands = 4;

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
        const TimePoint deadline = clock_.now() + slcan_answer_limit;
        for (;;) {
            const auto count = hear(std::min(clock_.now() + silence, deadline));
            if (!count)
                return std::unexpected(count.error());
            if (*count == 0 || clock_.now() >= deadline)
                return {};
        }
    }

    /// Sends and waits for the acknowledgement; `has_answered()` tells whether one came.
    std::expected<void, Error> command(std::string_view text, std::string_view refusal)
    {
        if (const auto sent = send(text); !sent)
            return sent;
        slcan::Reader reader;
        const TimePoint deadline = clock_.now() + slcan_answer_limit;
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
                if (end == slcan::Reader::End::line && reader.text().empty()) {
                    has_answered_ = true;
                    return {};
                }
            }
        }
    }

    bool has_answered() const { return has_answered_; }

private:
    std::expected<void, Error> send(std::string_view text)
    {
        const TimePoint deadline = clock_.now() + slcan_answer_limit;
        auto rest = bytes(text);
        for (;;) {
            const auto count = adapter_.write(rest);
            if (!count)
                return std::unexpected(count.error());
            rest = rest.subspan(*count);
            if (rest.empty())
                return {};
            if (clock_.now() >= deadline)
                return slcan_takes_no_bytes();
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
    bool has_answered_ = false;
    std::array<std::uint8_t, 256> heard_{};
};

} // namespace

std::unexpected<Error> refuse_slcan_rate(std::uint32_t bit_rate)
{
    return fail(Errc::unsupported, fmt::format("SLCAN has no code for {} bit/s on CAN; it has {}", bit_rate,
                                               fmt::join(slcan::bit_rates, ", ")));
}

std::unexpected<Error> slcan_takes_no_bytes()
{
    return fail(Errc::link_failed, "the SLCAN adapter takes no bytes; unplug it and plug it in again");
}

std::expected<std::unique_ptr<CanLink>, Error> SlcanLink::open(std::unique_ptr<ByteLink> adapter,
                                                               std::uint32_t bit_rate, Clock& clock)
{
    const auto code = slcan::code_of(bit_rate);
    if (!code)
        return refuse_slcan_rate(bit_rate);
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
    return std::unique_ptr<CanLink>(new SlcanLink(std::move(adapter), bit_rate, opening.has_answered()));
}

// ---- opening again ----

std::expected<std::unique_ptr<CanLink>, Error> SlcanReopening::step()
{
    auto done = adapter_ == nullptr ? begin() : std::expected<void, Error>{};
    if (done)
        done = send();
    if (done)
        done = hear();
    const bool is_over = answers_.size() >= commands || clock_->now() >= begun_ + slcan_answer_limit;
    if (done && is_over && !unsent_.empty())
        done = slcan_takes_no_bytes();
    if (done && is_over && is_refused())
        done = fail(Errc::link_failed, fmt::format("the SLCAN adapter refuses to open its CAN bus at {} bit/s again; "
                                                   "unplug it and plug it in again",
                                                   bit_rate_));
    if (done && is_over)
        return std::unique_ptr<CanLink>(new SlcanLink(std::move(adapter_), bit_rate_, !answers_.empty(), reader_));
    if (done)
        return fail(Errc::link_not_found, "the SLCAN adapter is there and opens its CAN bus");
    adapter_.reset();
    return std::unexpected(std::move(done.error()));
}

std::expected<void, Error> SlcanReopening::begin()
{
    const auto code = slcan::code_of(bit_rate_);
    if (!code)
        return refuse_slcan_rate(bit_rate_);
    auto port = open_port_();
    if (!port)
        return std::unexpected(std::move(port.error()));
    adapter_ = std::move(*port);
    unsent_ = fmt::format("\rC\rS{}\rO\r", *code);
    begun_ = clock_->now();
    reader_ = {};
    answers_.clear();
    return {};
}

std::expected<void, Error> SlcanReopening::send()
{
    if (unsent_.empty())
        return {};
    const auto count = adapter_->write(bytes(unsent_));
    if (!count)
        return std::unexpected(count.error());
    unsent_.erase(0, *count);
    return {};
}

std::expected<void, Error> SlcanReopening::hear()
{
    std::array<std::uint8_t, 256> heard;
    for (;;) {
        const auto arrival = adapter_->read(heard);
        if (!arrival)
            return std::unexpected(arrival.error());
        if (arrival->count == 0)
            return {};
        for (const std::uint8_t byte : std::span(heard).first(arrival->count)) {
            const auto end = reader_.take(byte);
            const bool is_refusal = end == slcan::Reader::End::refused;
            if (is_refusal || (end == slcan::Reader::End::line && reader_.text().empty()))
                answers_.push_back(!is_refusal);
        }
    }
}

/// The last two answers are those to the rate and to the opening. An adapter that was closed refuses to be closed, and
/// one that gives fewer answers than there are commands after the first CR may have said only that.
bool SlcanReopening::is_refused() const
{
    const std::size_t count = answers_.size();
    return count >= commands - 1 && !(answers_[count - 2] && answers_[count - 1]);
}

// ---- by name ----

namespace {

/// What a URI says.
struct Place {
    SerialPort port;
    std::uint32_t bit_rate = 0; ///< of CAN
};

std::expected<Place, Error> place_of(const Uri& uri)
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
    return Place{.port = {.device = uri.target, .bit_rate = baud->value_or(115'200)}, .bit_rate = rate};
}

} // namespace

std::expected<std::unique_ptr<CanLink>, Error> open_slcan(const Uri& uri, Clock& clock)
{
    const auto place = place_of(uri);
    if (!place)
        return std::unexpected(place.error());
    auto adapter = open_serial(place->port, clock);
    if (!adapter)
        return std::unexpected(adapter.error());
    return SlcanLink::open(std::move(*adapter), place->bit_rate, clock);
}

Reopen reopen_slcan(const Uri& uri, Clock& clock)
{
    const auto place = place_of(uri);
    if (!place)
        return [error = place.error()] { return std::unexpected(error); };
    const auto open_port = [port = place->port, &clock] { return open_serial(port, clock); };
    return [state = std::make_shared<SlcanReopening>(open_port, place->bit_rate,
                                                     clock)]() -> std::expected<AnyLink, Error> {
        auto link = state->step();
        if (!link)
            return std::unexpected(std::move(link.error()));
        return AnyLink{std::move(*link)};
    };
}

} // namespace sinew::link
