#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/echo.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/uri.hpp"

#include <string>

namespace sinew::link {

/// A serial port as it is opened: always raw 8N1 without flow control, the modem lines left alone.
struct SerialPort {
    std::string device;         ///< "/dev/ttyUSB0"
    std::uint32_t bit_rate = 0; ///< 0: as the device stands
    bool rs485 = false;         ///< let the driver switch the direction where it can
    Echo echo = Echo::off;      ///< whether the adapter hears itself
};

/// Opens the port for this program alone (TIOCEXCL and flock): what waits in its input is thrown away, and the latency
/// of the adapter is set to its lowest where the driver lets us. The rate that was really set stands in `state()`. A
/// symlink, such as those under /dev/serial/by-id, is followed at every open.
///
/// With `rs485` the driver is asked to switch the direction (TIOCSRS485). A driver that does not know it is used as it
/// is: nearly all USB adapters for RS-485 switch by themselves, and nothing tells the ones that do from the ones that
/// do not.
///
/// `link_not_found`, `link_denied` (with the group to join), `link_busy`, `unsupported` for a rate that the device
/// misses by more than 2 %, else `link_failed`. The clock must outlive the link.
std::expected<std::unique_ptr<ByteLink>, Error> open_serial(const SerialPort& port, Clock& clock);

/// The schemes serial, rs485 and pty with their options `baud` and `echo=on|off|auto`. A pty may go without `baud`:
/// then the simulator behind it sees the rate that it started with. The others must be given one: a wrong guess looks
/// like a dead device.
std::expected<std::unique_ptr<ByteLink>, Error> open_serial(const Uri& uri, Clock& clock);

} // namespace sinew::link
