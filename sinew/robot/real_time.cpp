#include "sinew/bus/real_time.hpp"

#include "sinew/link/clock.hpp"
#include "sinew/robot/core.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>

/// What `[bus.NAME.realtime]` asks of the thread that drives the buses.
namespace sinew::robot {
namespace {

/// Of the calling thread. A `std::thread::id` may come again when its thread is gone.
std::uint64_t own_number()
{
    static std::atomic<std::uint64_t> given{0};
    thread_local const std::uint64_t number = ++given;
    return number;
}

} // namespace

void Core::ask_for_real_time()
{
    if (driver_ == own_number())
        return;
    driver_ = own_number();
    // Virtual time is never late, and a loop that never waits would take a processor for itself.
    if (dynamic_cast<link::RealClock*>(clock) == nullptr)
        return;
    const auto tell = [&](const std::string& bus, std::string_view says) {
        incidents.add({clock->now(), {}, Errc::unsupported, fmt::format("bus {}: {}", bus, says)});
    };
    // One thread drives all buses, so it asks for the most that any of them wants; a refusal names the bus that does.
    bus::RealTime wanted;
    const config::Bus *locks = nullptr, *first = nullptr, *bound = nullptr;
    for (const auto& bus : file.buses) {
        const auto& own = bus.realtime;
        if (own.lock_memory && locks == nullptr)
            locks = &bus;
        if (own.priority && (first == nullptr || own.priority->value > first->realtime.priority->value))
            first = &bus;
        if (own.processor && bound == nullptr)
            bound = &bus;
        else if (own.processor && own.processor->value != bound->realtime.processor->value)
            tell(bus.name, fmt::format("processor {} is not taken: one thread drives all buses, and bus {} has it on "
                                       "processor {}",
                                       own.processor->value, bound->name, bound->realtime.processor->value));
    }
    wanted.lock_memory = locks != nullptr;
    if (first != nullptr)
        wanted.priority = static_cast<int>(first->realtime.priority->value);
    if (bound != nullptr)
        wanted.processor =
            static_cast<int>(std::min<std::int64_t>(bound->realtime.processor->value, std::numeric_limits<int>::max()));
    for (const auto& refused : bus::apply(wanted)) {
        const config::Bus* whose = refused.option == "lock_memory" ? locks
                                   : refused.option == "priority"  ? first
                                                                   : bound;
        tell(whose->name, refused.reason);
    }
}

} // namespace sinew::robot
