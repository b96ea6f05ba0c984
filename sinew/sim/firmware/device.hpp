#pragma once
#include "sinew/sim/wire/station.hpp"

#include <string_view>

namespace sinew::sim {

/// What a device is doing, for people to look at.
struct Look {
    double position_rad = 0.0;
    double velocity_rad_s = 0.0;
    std::string_view mode; ///< "position", "passive", … in the family's own words
};

/// The firmware of one simulated device: messages in, answers out. It knows no wire and no bus, keeps its settings, and
/// carries its own plant. Single-threaded; `advance` and `hear` allocate nothing.
class Device : public Station
{
public:
    virtual int id() const = 0;
    virtual Look look() const = 0;
    /// Power off and on: what is not stored is lost.
    virtual void power_cycle() = 0;
};

} // namespace sinew::sim
