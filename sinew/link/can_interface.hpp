#pragma once
#include "sinew/base/error.hpp"

#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What Linux knows of its CAN interfaces, asked through rtnetlink: nothing is changed, no rights are needed.
namespace sinew::link {

/// How far a controller has withdrawn from its bus, by the errors it has seen (ISO 11898-1, fault confinement).
enum class CanState : std::uint8_t {
    unknown,       ///< the interface has no controller (vcan) or does not tell
    error_active,  ///< as it should be
    error_warning, ///< 96 errors
    error_passive, ///< 128: it no longer marks the errors it sees
    bus_off,       ///< 256: it sends and hears nothing until it is restarted
    stopped,       ///< the interface is down
    sleeping
};

/// "error-active", as `ip -details link show` writes it.
std::string_view to_word(CanState state);

struct CanInterface {
    std::string name;             ///< "can0"
    int index = 0;                ///< of the interface, as sockets want it
    std::string kind;             ///< "can", "vcan", "slcan" …; empty: the driver gives none
    bool is_up = false;           ///< administratively, and running
    std::uint32_t bit_rate = 0;   ///< bits per second; 0: it has none (vcan) or none is set yet
    std::uint32_t tx_queue = 0;   ///< txqueuelen: frames that may wait in the kernel; 0: no queue (vcan)
    std::uint32_t restart_ms = 0; ///< how long after bus-off the kernel restarts it by itself; 0: never
    CanState state = CanState::unknown;
    std::uint16_t tx_errors = 0; ///< the controller's own counters; 0 where the driver does not tell
    std::uint16_t rx_errors = 0;
    std::uint32_t bus_offs = 0; ///< since the driver was loaded
    std::uint32_t restarts = 0;
    std::uint64_t rx_dropped = 0; ///< frames that the driver lost, for no one fetched them in time
    std::uint64_t tx_dropped = 0;
};

/// All CAN interfaces of this machine, up or down. Empty where the kernel has none. `link_failed` where the system does
/// not answer. Asks the heap for memory and the kernel for milliseconds: for opening and diagnosis.
std::expected<std::vector<CanInterface>, Error> can_interfaces();

/// One by its name. `link_not_found` says which there are.
std::expected<CanInterface, Error> can_interface(std::string_view name);

/// One message of the kernel (RTM_NEWLINK with its header); nothing where it is no CAN interface or cut short. Pure.
std::optional<CanInterface> parse_can_interface(std::span<const std::uint8_t> message);

/// How an interface is brought up, for messages.
std::string how_to_bring_up(const CanInterface& interface);

} // namespace sinew::link
