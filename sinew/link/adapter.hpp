#pragma once
#include <optional>
#include <string>
#include <vector>

/// What the operating system tells about the adapter behind a serial port. Everything here only looks; nothing opens
/// the port, which would raise its modem lines and wake the boards that hang on them.
namespace sinew::link {

/// Where the operating system shows itself; other folders in tests.
struct Roots {
    std::string dev = "/dev";
    std::string sys = "/sys";
    std::string proc = "/proc";
};

/// A program that has the port open.
struct Holder {
    int pid = 0;
    std::string program; ///< "minicom"; empty where it is hidden from us
};

/// What the driver of an open port says of itself. Absent where it does not know the question.
struct DriverSettings {
    std::optional<bool> low_latency; ///< ASYNC_LOW_LATENCY
    std::optional<bool> rs485;       ///< the kernel switches the direction
};

struct Adapter {
    std::string device; ///< the device file itself, "/dev/ttyUSB0", where a symlink was given
    bool is_there = false;
    std::string by_id;         ///< "/dev/serial/by-id/usb-FTDI_…-if00-port0", the name that stays; empty: none
    std::string serial_number; ///< of the USB device, which tells it from its twins; empty: it has none
    std::string driver;        ///< "ftdi_sio", "cp210x", "cdc_acm"; empty: unknown, or no hardware
    /// How long the adapter may keep received bytes back to collect more (FTDI: 16 ms unless it was changed). Absent:
    /// the driver has no such timer.
    std::optional<int> latency_timer_ms;
    std::optional<bool> low_latency; ///< of ports of the board, whose driver tells without being opened
    std::vector<Holder> holders;     ///< programs of other users show only to root
    bool may_open = false;           ///< this program is permitted to read and write it
    std::string group;               ///< to join for the permission; empty where that would not help
};

/// Looks at the port; a device that is not there leaves everything else empty.
Adapter look_at_adapter(const std::string& device, const Roots& roots = {});

/// Asks the driver through an open port (`ByteLink::handle()`).
DriverSettings driver_settings(int fd);

/// The name under /dev/serial/by-id, made of vendor, product, serial number and interface; empty: none.
std::string find_by_id(const std::string& device, const Roots& roots = {});

/// The serial number of the USB device that the port belongs to; empty: none.
std::string find_serial_number(const std::string& device, const Roots& roots = {});

/// Who holds the lock (flock) on the file that `device` names, asked of the kernel's list, for trying the lock would
/// turn away a program that takes it at this moment. Absent: nobody.
std::optional<Holder> lock_holder(const std::string& device, const Roots& roots = {});

/// "minicom (pid 1234)", of the holder of the lock or else of all that have it open; empty: nobody who shows.
std::string who_holds(const std::string& device, const Roots& roots = {});

} // namespace sinew::link
