#pragma once
#include "sinew/bus/bus.hpp"

namespace sinew::cli {

/// From now on Ctrl-C and SIGTERM end nothing by themselves: they set a flag and wake the buses that were registered.
void catch_interrupts();
bool interrupted();
/// Takes back an interrupt that was seen, so that the buses can be used to stop what moves.
void clear_interrupt();
/// As if Ctrl-C had been pressed.
void interrupt();
/// Waits until there is something to read, or the end of it. False: an interrupt came, now or before.
bool wait_for_input(int fd);

/// For verbs that move something. A program that is suspended commands nothing, and its motor turns on: from now on
/// Ctrl-Z is a Ctrl-C, and a terminal in which it runs in the background does not suspend it either.
void catch_suspension();
/// Whether it was Ctrl-Z.
bool was_suspension();
/// Says on stderr that it is one, and why it ends the program.
void tell_of_suspension();

/// While one of these lives a signal is only remembered: what brings a motor to rest is not cut short by a second
/// Ctrl-C. Takes back an interrupt that was seen, so that the buses can be used.
class Undisturbed
{
public:
    Undisturbed();
    ~Undisturbed();
    Undisturbed(const Undisturbed&) = delete;
    Undisturbed& operator=(const Undisturbed&) = delete;
};

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
