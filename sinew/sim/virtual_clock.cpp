#include "sinew/sim/virtual_clock.hpp"

namespace sinew::sim {

void VirtualClock::wait(std::span<const link::Handle>, TimePoint deadline)
{
    while (!has_news()) {
        const TimePoint next = world_->next_event();
        if (next > deadline || next == TimePoint::max()) {
            if (deadline != TimePoint::max())
                world_->advance(deadline);
            return;
        }
        world_->advance(next);
    }
}

bool VirtualClock::has_news()
{
    bool any = false;
    for (Inbox* inbox : inboxes_)
        any |= inbox->has_news();
    return any;
}

} // namespace sinew::sim
