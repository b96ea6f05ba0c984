#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/sim/world.hpp"

#include <vector>

namespace sinew::sim {

/// What a host has received from the world and not yet read.
class Inbox
{
public:
    virtual ~Inbox() = default;
    /// Whether there is something to read that was not there, or not first in line, when this was asked last. So what
    /// nobody reads wakes nobody twice.
    virtual bool has_news() = 0;
};

/// The time of a world. It moves in `wait` alone: to the next event that brings something to a host, or to the
/// deadline, whichever is first. The same calls give the same times on every machine, and a wait costs what happens in
/// it, not how long it is.
///
/// Descriptors are not looked at. A wait without deadline returns at once when nothing is going to happen.
/// Single-threaded, `now()` included. The world must outlive it.
class VirtualClock final : public link::Clock
{
public:
    explicit VirtualClock(World& world) : world_(&world) {}

    /// The inbox must outlive the clock.
    void watch(Inbox& inbox) { inboxes_.push_back(&inbox); }

    TimePoint now() const override { return world_->now(); }
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override;

private:
    bool has_news();

    World* world_;
    std::vector<Inbox*> inboxes_;
};

} // namespace sinew::sim
