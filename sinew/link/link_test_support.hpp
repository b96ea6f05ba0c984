#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// What the tests of this room share. Nothing waits longer than `patience`, and only a test that fails waits that long.
namespace sinew::link::test {

inline constexpr Duration patience = std::chrono::seconds{5};

inline std::span<const std::uint8_t> bytes(std::string_view text)
{
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Waits for the handle until `done`; false when patience ran out.
inline bool until(Clock& clock, int handle, const std::function<bool()>& done)
{
    const TimePoint deadline = clock.now() + patience;
    while (!done()) {
        if (clock.now() >= deadline)
            return false;
        const Handle handles[] = {{.fd = handle}};
        clock.wait(handles, deadline);
    }
    return true;
}

/// Reads until that many bytes have come; fewer when patience ran out or the link hung up.
inline std::string read(ByteLink& link, Clock& clock, std::size_t count)
{
    std::string text;
    until(clock, link.handle(), [&] {
        std::array<std::uint8_t, 256> into;
        const auto arrival = link.read(std::span(into).first(std::min(into.size(), count - text.size())));
        if (!arrival)
            return true;
        EXPECT_LE(arrival->at, clock.now());
        text.append(into.begin(), into.begin() + arrival->count);
        return text.size() == count;
    });
    return text;
}

/// The error that reading ends with; patience running out gives none.
inline std::optional<Error> read_until_error(ByteLink& link, Clock& clock)
{
    std::optional<Error> error;
    until(clock, link.handle(), [&] {
        std::array<std::uint8_t, 256> into;
        if (const auto arrival = link.read(into); !arrival)
            error = arrival.error();
        return error.has_value();
    });
    return error;
}

/// The real clock, which serves the other end before every wait and wakes for its handle as well: lets one thread be
/// both ends of a conversation.
class ServingClock final : public Clock
{
public:
    ServingClock(int handle, std::function<void()> serve) : handle_(handle), serve_(std::move(serve)) {}
    TimePoint now() const override { return real_.now(); }
    void wait(std::span<const Handle> handles, TimePoint deadline) override
    {
        serve_();
        std::vector<Handle> all(handles.begin(), handles.end());
        all.push_back({.fd = handle_});
        real_.wait(all, deadline);
    }

private:
    RealClock real_;
    int handle_;
    std::function<void()> serve_;
};

/// Every wait lasts to its deadline, at once.
class HurryingClock final : public Clock
{
public:
    TimePoint now() const override { return time; }
    void wait(std::span<const Handle>, TimePoint deadline) override { time = std::max(time, deadline); }
    TimePoint time{};
};

/// A link whose reads are given by the test, one entry a read, and which takes at most `room` bytes.
class ScriptedLink final : public ByteLink
{
public:
    std::deque<std::string> reads;
    std::string written;
    std::size_t room = 1000;

    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        const std::size_t count = std::min(bytes.size(), room);
        written.append(bytes.begin(), bytes.begin() + count);
        room -= count;
        return count;
    }
    std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override
    {
        if (reads.empty())
            return Arrival{};
        std::string& first = reads.front();
        const std::size_t count = std::min(into.size(), first.size());
        std::copy_n(first.begin(), count, into.begin());
        first.erase(0, count);
        if (first.empty())
            reads.pop_front();
        return Arrival{.count = count, .at = TimePoint{} + Duration{++reads_}};
    }
    int handle() const override { return 77; }
    LinkState state() const override { return {.open = true, .bit_rate = 9600}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }

private:
    int reads_ = 0;
};

} // namespace sinew::link::test
