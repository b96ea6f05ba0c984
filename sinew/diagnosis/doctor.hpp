#pragma once
#include "sinew/diagnosis/finding.hpp"
#include "sinew/family/families.hpp"
#include "sinew/link/adapter.hpp"
#include "sinew/link/can_interface.hpp"
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/report.hpp"

#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// Looks at a link and says what is wrong with it. It only reads: nothing moves, nothing is written, and no question is
/// anything but a read to a device that hears it at another bit rate. The checks go from the port to the devices; one
/// that fails does not hide those after it that are still possible.
namespace sinew::diagnosis {

/// A device that should be there.
struct Expected {
    int id = -1;
    std::string joint;
    DeviceSpec spec;
};

struct Subject {
    std::string bus;                ///< its name in the robot file; empty: none
    std::string link;               ///< its URI
    const Family* family = nullptr; ///< nullptr: whoever is found
    std::uint32_t bit_rate = 0;     ///< for links that do not say one; 0: as the link opens
    bool rate_is_guessed = false;   ///< nobody has said the rate of the link: another one is no error
    std::vector<Expected> expected; ///< in the order of the robot file, which is taken for that of the chain
};

/// A link, open, and its clock, which must outlive the examination.
struct Opened {
    link::AnyLink link;
    link::Clock* clock = nullptr;
};

/// What an examination needs from outside. All are called from the thread that examines.
struct Surroundings {
    std::function<std::expected<Opened, Error>(const std::string& link)> open;
    std::function<void(const Finding&)> found{};          ///< as they are made; may be left out
    std::function<void(std::string_view)> progress{};     ///< what is being done, for people; may be left out
    std::function<bool()> stopped = [] { return false; }; ///< ends it between two questions
    link::Roots roots{};                                  ///< where the system shows its ports
    /// What the system knows of a CAN interface.
    std::function<std::expected<link::CanInterface, Error>(std::string_view name)> can_interface = link::can_interface;
};

/// One check of the walk.
struct CheckInfo {
    std::string_view name;
    std::string_view says; ///< what it looks at
};

/// In the order of the walk.
std::vector<CheckInfo> checks();

struct Examination {
    std::vector<Finding> findings;          ///< in the order of the walk
    std::vector<std::string_view> left_out; ///< checks that were not possible
    link::Report adapter;                   ///< what the link tells of itself at the end; empty where it is not open
};

/// A few seconds of a healthy bus; a minute or so where nobody answers and all bit rates are tried.
Examination examine(const Subject& subject, const Surroundings& surroundings);

} // namespace sinew::diagnosis
