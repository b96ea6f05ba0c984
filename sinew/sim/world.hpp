#pragma once
#include "sinew/config/robot_file.hpp"
#include "sinew/family/families.hpp"
#include "sinew/sim/fault.hpp"
#include "sinew/sim/firmware/device.hpp"
#include "sinew/sim/plant/supply.hpp"
#include "sinew/sim/wire/can_wire.hpp"
#include "sinew/sim/wire/serial_wire.hpp"

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sinew::sim {

/// One bus of a world: its copper, and what its robot file says about it.
struct WorldBus {
    std::string name;
    const Family* family = nullptr;
    std::uint32_t bit_rate = 0; ///< at which its devices begin, unless they are told otherwise
    std::variant<SerialWire, CanWire> wire;
    std::vector<Supply> supplies; ///< one for each voltage that its devices are made for
};

/// The other end of all wires of a robot: simulated devices on simulated copper, in a time of its own that begins at
/// `TimePoint{}` with power-on. Nothing in it happens by itself: whoever owns it moves it on. Single-threaded; no heap
/// once it is made.
///
/// Wires run from event to event, exact to the nanosecond. Devices, their plants and the supplies run in ticks of 1 ms
/// for all of them at once: what a device is told between two ticks it does in the next one.
class World
{
public:
    /// Checks the robot file as `resolve` does, and what it says about the simulated world.
    static std::expected<std::unique_ptr<World>, Error> make(const config::RobotFile& file);

    // ---- what goes wrong ----

    /// From `fault.at_s` seconds on from now. What it names must be there. Asks the heap for memory.
    void inject(const Fault& fault);
    /// Takes back all that hits this joint or bus, waiting or not. Returns how many faults that were.
    std::size_t mend(std::string_view target);
    /// What hits this joint or bus at this moment.
    std::vector<FaultKind> faults_of(std::string_view target) const;

    TimePoint now() const { return now_; }
    /// When something happens next on a wire; `TimePoint::max()`: nothing will until a host sends.
    TimePoint next_event() const;
    /// Runs wires and devices up to `until` and makes it the present. Earlier than now: does nothing.
    void advance(TimePoint until);

    // ---- what its devices keep without power ----

    /// As the text of a flash file, whole and consistent at this moment.
    std::string flash() const;
    std::uint64_t flash_writes() const; ///< of all devices
    /// Before anything happened in it. `bad_file`: some devices may have it and some not; give the world up.
    std::expected<void, Error> restore(const config::FlashFile& flash);

    const config::RobotFile& file() const { return file_; }
    std::vector<std::string_view> joints() const;  ///< in the order of the file
    std::span<WorldBus> buses() { return buses_; } ///< in the order of the file
    /// `link_not_found` that names the buses there are. An empty name is the bus of a robot that has one only.
    std::expected<WorldBus*, Error> find_bus(std::string_view name);

    Device* find_device(std::string_view joint); ///< nullptr: none
    /// What the device of a joint is doing now. `unknown_name` suggests the nearest.
    std::expected<Look, Error> look(std::string_view joint);

private:
    struct Inhabitant {
        std::string joint;
        std::unique_ptr<Device> device;
        std::size_t bus = 0;
        std::size_t supply = 0; ///< of its bus
    };

    /// A fault with its time.
    struct Scheduled {
        Fault fault;
        TimePoint begins{};
        TimePoint ends{};
        bool is_on = false;
        bool hits(std::string_view target) const { return fault.joint == target || fault.bus == target; }
    };

    World() = default;
    void run_wires(TimePoint until);
    void run_tick();
    void run_faults();
    void turn(Scheduled& scheduled, bool on);
    void turn_device(const Fault& fault, Device& device, bool on);
    void turn_supplies(const Fault& fault, bool on);
    void turn_wire(const Fault& changed);

    config::RobotFile file_;
    std::vector<Scheduled> faults_;
    TimePoint now_{};
    TimePoint next_tick_{};
    std::vector<Inhabitant> inhabitants_;
    std::vector<WorldBus> buses_;
};

} // namespace sinew::sim
