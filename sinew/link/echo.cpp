#include "sinew/link/echo.hpp"

#include <fmt/format.h>

namespace sinew::link {
namespace {

using Bytes = std::span<const std::uint8_t>;

Bytes from(Bytes bytes, std::size_t first)
{
    return bytes.subspan(std::min(first, bytes.size()));
}

/// Equal as far as both go.
bool agree(Bytes a, Bytes b)
{
    const std::size_t both = std::min(a.size(), b.size());
    return std::ranges::equal(a.first(both), b.first(both));
}

/// Whether it may be the beginning of an echo in which at most one byte was flipped, added or lost.
bool may_be_echo(Bytes heard, Bytes expected)
{
    const auto same = static_cast<std::size_t>(std::ranges::mismatch(heard, expected).in1 - heard.begin());
    return agree(from(heard, same + 1), from(expected, same + 1)) ||
           agree(from(heard, same + 1), from(expected, same)) || agree(from(heard, same), from(expected, same + 1));
}

} // namespace

std::expected<Echo, Error> echo_option(const Uri& uri)
{
    const auto echo = uri.option("echo").value_or("off");
    if (echo == "off")
        return Echo::off;
    if (echo == "on")
        return Echo::on;
    if (echo == "auto")
        return Echo::automatic;
    return fail(Errc::bad_uri, fmt::format("option echo must be on, off or auto, not '{}'", echo));
}

std::unique_ptr<ByteLink> with_echo(std::unique_ptr<ByteLink> link, Echo echo, const Clock& clock)
{
    if (echo == Echo::off)
        return link;
    return std::make_unique<EchoLink>(std::move(link), echo, clock);
}

EchoLink::EchoLink(std::unique_ptr<ByteLink> inner, Echo echo, const Clock& clock)
    : inner_(std::move(inner)), echo_(echo), clock_(&clock)
{
}

std::expected<std::size_t, Error> EchoLink::write(std::span<const std::uint8_t> bytes)
{
    if (echo_ == Echo::off)
        return inner_->write(bytes);
    const TimePoint now = clock_->now();
    if (!expected_.empty() && given_up(now)) {
        // A damaged echo would still have nearly all of its bytes; a few are an answer that looked like one.
        if (echo_ == Echo::automatic && !heard_.empty() && heard_.size() + 1 < expected_.size())
            found_no_echo();
        forget();
    }
    const auto count = inner_->write(bytes.first(std::min(bytes.size(), capacity - expected_.size())));
    if (count && *count > 0 && echo_ != Echo::off) {
        expected_.append(bytes.first(*count));
        written_at_ = now;
    }
    return count;
}

/// Whether the whole of what is expected will not be heard any more.
bool EchoLink::given_up(TimePoint now) const
{
    const auto rate = inner_->state().bit_rate;
    const Duration on_wire = rate == 0 ? Duration{} : bit_time(10 * static_cast<std::int64_t>(expected_.size()), rate);
    return damaged_ || now - written_at_ > on_wire + patience;
}

std::expected<Arrival, Error> EchoLink::read(std::span<std::uint8_t> into)
{
    if (passed_.empty() && !into.empty() && heard_.size() < capacity) {
        // All that is held back may come out together with what is read now; beyond that nothing is left in here
        // that the caller, who waits for the handle, would not hear of.
        std::array<std::uint8_t, capacity> came;
        const auto arrival = inner_->read(std::span(came).first(std::min(into.size(), capacity - heard_.size())));
        if (!arrival)
            return arrival;
        if (arrival->count > 0)
            at_ = arrival->at;
        for (std::size_t i = 0; i < arrival->count; ++i)
            hear(came[i]);
    }
    const std::size_t count = std::min(into.size(), passed_.size());
    std::ranges::copy(passed_.bytes().first(count), into.begin());
    passed_.drop(count);
    return Arrival{.count = count, .at = at_};
}

void EchoLink::hear(std::uint8_t byte)
{
    if (expected_.empty())
        passed_.append({&byte, 1});
    else if (echo_ == Echo::on)
        hear_where_an_echo_is(byte);
    else if (!damaged_) // what follows a damaged echo is no answer
        hear_where_an_echo_may_be(byte);
}

void EchoLink::hear_where_an_echo_is(std::uint8_t byte)
{
    heard_.append({&byte, 1});
    while (!agree(heard_.bytes(), expected_.bytes())) {
        heard_.drop(1);
        damaged_ = true;
    }
    if (heard_.size() == expected_.size())
        forget();
}

void EchoLink::hear_where_an_echo_may_be(std::uint8_t byte)
{
    heard_.append({&byte, 1});
    if (std::ranges::equal(heard_.bytes(), expected_.bytes())) {
        echo_ = Echo::on;
        forget();
    } else if (!may_be_echo(heard_.bytes(), expected_.bytes())) {
        passed_.append(heard_.bytes());
        found_no_echo();
        forget();
    } else if (heard_.size() > expected_.size()) {
        damaged_ = true;
    }
}

void EchoLink::found_no_echo()
{
    if (++unechoed_ == writes_to_decide)
        echo_ = Echo::off;
}

void EchoLink::forget()
{
    expected_.clear();
    heard_.clear();
    damaged_ = false;
}

} // namespace sinew::link
