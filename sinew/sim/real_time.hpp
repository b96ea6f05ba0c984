#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/sim/world.hpp"

#include <atomic>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::sim {

class RealPort;

/// Somebody else who is served in the thread of a simulator: a prompt, a control socket.
class Visitor
{
public:
    virtual ~Visitor() = default;
    virtual std::span<const link::Handle> handles() = 0; ///< what to wait for besides the ports
    virtual void serve() = 0;                            ///< whenever something woke the simulator; must not block
    virtual void hear(std::string_view) {}               ///< a sentence on what happened outside, such as a lost link
};

/// A robot in real time, behind what any program opens as it would open hardware: pseudo terminals as a rule, TCP ports
/// and CAN interfaces where it is asked for them, all at once. Serial buses are bare bytes, and devices answer only
/// when the program set their bit rate (a TCP port runs at the bus's own); CAN buses on a terminal are SLCAN adapters,
/// and the rate that the program chose with S counts. Programs may come and go.
class RealTimeSimulator
{
public:
    struct BusLink {
        std::string bus;
        std::string_view family;
        std::string uri; ///< "serial:/dev/pts/5?baud=1500000", "slcan:/dev/pts/7?bitrate=1000000"
    };
    /// Where a bus is to be found instead of behind a pseudo terminal: the link that a program then opens.
    struct Place {
        std::string bus;
        std::string uri; ///< "tcp://127.0.0.1:4001" for a serial bus, "can:vcan0" for CAN
    };

    /// `link_failed` when there are no pseudo terminals, `unknown_name` for a place of no bus, the errors of
    /// `open_port`. The clock, a real one, must outlive the simulator.
    static std::expected<std::unique_ptr<RealTimeSimulator>, Error> make(const config::RobotFile& file,
                                                                         link::Clock& clock,
                                                                         std::span<const Place> places = {});
    ~RealTimeSimulator();

    std::span<const BusLink> links() const { return links_; } ///< in the order of the file

    /// Serves all buses in this thread until the flag is set or `until` is reached. It sleeps while nothing is to be
    /// done, and looks at the flag at least every `idle_step`; a signal wakes it at once. Time that passes outside
    /// `run` passes for the world as well.
    void run(const std::atomic<bool>& stop, TimePoint until = TimePoint::max(), Visitor* visitor = nullptr);

    /// What passes between programs and a bus, as their adapters see it.
    struct Passed {
        const BusLink* bus = nullptr;
        wire::Direction direction{};
        std::span<const std::uint8_t> bytes;
        const wire::Frame* frame = nullptr; ///< on CAN
        TimePoint at{};                     ///< of the world
    };
    /// Called from the thread that runs it, and not to be changed from within; nullptr: nobody.
    void set_tap(const std::function<void(const Passed&)>& tap);

    /// How often something was due more than `late_limit` before it was done, because the machine had other work.
    /// Readable from any thread.
    std::uint64_t late() const { return late_.load(std::memory_order_relaxed); }
    World& world() { return *world_; } ///< only from the thread that runs it

    static constexpr Duration idle_step = std::chrono::milliseconds{5};
    static constexpr Duration late_limit = std::chrono::milliseconds{10};

private:
    RealTimeSimulator(std::unique_ptr<World> world, link::Clock& clock);
    void serve(TimePoint now);
    void tell(Visitor& visitor);
    TimePoint world_time() const { return TimePoint{} + (clock_->now() - power_on_); }

    std::unique_ptr<World> world_;
    link::Clock* clock_;
    TimePoint power_on_;
    std::vector<BusLink> links_;
    std::vector<std::unique_ptr<RealPort>> ports_;
    std::atomic<std::uint64_t> late_ = 0;
};

} // namespace sinew::sim
