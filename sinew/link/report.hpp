#pragma once
#include "sinew/link/adapter.hpp"
#include "sinew/link/can_interface.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/uri.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// What an open link tells of itself and of its adapter, for whoever looks at a bus.
namespace sinew::link {

/// One thing as it stands, whether it was asked for or not. The names stay: JSON has them.
struct Setting {
    std::string_view name; ///< "low_latency"
    std::variant<bool, std::int64_t, std::string> value;
    std::string says; ///< "low latency refused by the driver"
};

/// How often something happened to this link since it was opened.
struct Tally {
    std::string_view name; ///< "overruns"
    std::string_view says; ///< "overruns of the controller"
    std::uint64_t count = 0;
    enum class Means : std::uint8_t { nothing, trouble, loss } means{}; ///< loss: a frame is gone each time
};

struct Report {
    std::vector<Setting> settings;
    std::vector<Tally> tallies; ///< of CAN links; all of the kind, those that never happened too
};

/// Of a serial port: the driver, low latency (always asked for), the latency timer and, with `rs485:`, whether the
/// driver switches the direction. Of an SLCAN adapter also whether it answers and the flags that it told last. Of a CAN
/// interface what the kernel tells. Of others nothing. Asks the system: not for the hot path.
Report report_of(const Uri& uri, const AnyLink& link, const Roots& roots = {});

/// The settings of a port, from what its adapter and its driver say.
std::vector<Setting> settings_of(const Adapter& adapter, const DriverSettings& driver, bool wants_rs485);

std::vector<Setting> settings_of(const CanInterface& interface);

/// What `settings` say, as one line; empty: nothing.
std::string to_words(const std::vector<Setting>& settings);

} // namespace sinew::link
