#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"

#include <array>
#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <string_view>

/// What the tests of this room share. Nothing waits longer than `patience`, and only a test that fails waits that long.
namespace sinew::link::test
{

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

/// The real clock, with something to do before every wait: lets one thread be both ends of a conversation.
class ServingClock final : public Clock
{
public:
    explicit ServingClock(std::function<void()> serve) : serve_(std::move(serve)) {}
    TimePoint now() const override { return real_.now(); }
    void wait(std::span<const Handle> handles, TimePoint deadline) override
    {
        serve_();
        real_.wait(handles, deadline);
    }

private:
    RealClock real_;
    std::function<void()> serve_;
};

} // namespace sinew::link::test
