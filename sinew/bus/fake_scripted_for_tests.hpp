#pragma once
#include "sinew/bus/bus.hpp"
#include "sinew/bus/fake_family.hpp"

#include <deque>
#include <gtest/gtest.h>
#include <type_traits>
#include <vector>

/// A bus on a link that does what a test has written down.
namespace sinew::bus::fake {

inline std::vector<std::uint8_t> bytes_of(const wire::Frame& frame)
{
    return {frame.bytes().begin(), frame.bytes().end()};
}

/// Time that passes only where somebody waits: to the deadline, or to the next arrival.
class ScriptedClock final : public link::Clock
{
public:
    TimePoint now() const override { return now_; }
    void wait(std::span<const link::Handle>, TimePoint deadline) override
    {
        ++waits;
        const TimePoint next = std::min(deadline, next_arrival ? next_arrival() : TimePoint::max());
        ASSERT_NE(next, TimePoint::max()) << "a wait without an end";
        now_ = std::max(now_, next);
    }

    int waits = 0;
    std::function<TimePoint()> next_arrival;

private:
    TimePoint now_{std::chrono::seconds(1)};
};

/// `Base` is one of the two kinds of links. What is written is answered a while later with the next of `answers`.
template <class Base>
class ScriptedLink final : public Base
{
public:
    using Item = std::conditional_t<std::is_same_v<Base, link::ByteLink>, std::uint8_t, wire::Frame>;
    struct Piece {
        std::vector<Item> items;
        TimePoint at;
        bool more = false; ///< as the link says
    };
    static constexpr Duration delay = std::chrono::milliseconds(1);

    explicit ScriptedLink(const link::Clock& clock) : clock_(clock) {}

    std::expected<std::size_t, Error> write(std::span<const Item> items) override
    {
        ++writes;
        if (is_gone)
            return std::unexpected(Error{.code = Errc::link_lost});
        if (refuses)
            return std::unexpected(Error{.code = Errc::link_failed});
        const std::size_t room = next_of(rooms, items.size());
        if (room > 0)
            written.emplace_back(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(room));
        if (auto answer = room == items.size() ? next_of(answers, {}) : std::vector<Item>{}; !answer.empty())
            pieces.push_back({std::move(answer), clock_.now() + delay});
        return room;
    }
    std::expected<link::Arrival, Error> read(std::span<Item> into) override
    {
        ++reads;
        if (is_gone)
            return std::unexpected(Error{.code = Errc::link_lost});
        if (pieces.empty() || pieces.front().at > clock_.now())
            return link::Arrival{};
        const Piece piece = next_of(pieces, {});
        EXPECT_LE(piece.items.size(), into.size());
        std::ranges::copy(piece.items, into.begin());
        return link::Arrival{.count = piece.items.size(), .at = piece.at + reads_late_by, .more = piece.more};
    }
    int handle() const override { return -1; }
    link::LinkState state() const override { return {.open = !is_gone, .bit_rate = 100'000}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }

    std::vector<Item> all_written() const
    {
        std::vector<Item> all;
        for (const auto& items : written)
            all.insert(all.end(), items.begin(), items.end());
        return all;
    }

    std::deque<std::size_t> rooms; ///< how much the next writes take; after that all of it
    std::deque<std::vector<Item>> answers;
    std::deque<Piece> pieces; ///< on their way
    std::vector<std::vector<Item>> written;
    Duration reads_late_by{}; ///< as it says, which is when it was read
    bool is_gone = false;
    bool refuses = false; ///< what is written, and stays open
    int writes = 0;
    int reads = 0;

private:
    template <class T>
    static T next_of(std::deque<T>& queue, T otherwise)
    {
        if (queue.empty())
            return otherwise;
        T next = std::move(queue.front());
        queue.pop_front();
        return next;
    }

    const link::Clock& clock_;
};

template <class Base>
struct Scripted {
    explicit Scripted(const wire::Protocol& protocol, Settings settings = {})
        : Scripted(std::make_unique<ScriptedLink<Base>>(clock), protocol, settings)
    {
    }

    ScriptedClock clock{};
    ScriptedLink<Base>& link;
    Bus bus;

private:
    Scripted(std::unique_ptr<ScriptedLink<Base>> made, const wire::Protocol& protocol, Settings settings)
        : link(*made), bus("scripted", link::AnyLink{std::unique_ptr<Base>{std::move(made)}}, clock, protocol, settings)
    {
        clock.next_arrival = [this] { return link.pieces.empty() ? TimePoint::max() : link.pieces.front().at; };
    }
};

} // namespace sinew::bus::fake
