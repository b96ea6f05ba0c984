#pragma once
#include "sinew/bus/bus.hpp"

namespace sinew::cli {

/// From now on Ctrl-C and SIGTERM end nothing by themselves: they set a flag and wake the buses that were registered.
void catch_interrupts();
bool interrupted();
/// Takes back an interrupt that was seen, so that the buses can be used to stop what moves.
void clear_interrupt();

/// A bus whose exchange an interrupt ends at the next frame boundary, for as long as this lives.
class StopOnInterrupt
{
public:
    explicit StopOnInterrupt(bus::Bus& bus);
    ~StopOnInterrupt();
    StopOnInterrupt(const StopOnInterrupt&) = delete;
    StopOnInterrupt& operator=(const StopOnInterrupt&) = delete;

private:
    bus::Bus* bus_;
};

} // namespace sinew::cli
