#pragma once
#include "sinew/config/flash_file.hpp"
#include "sinew/sim/plant/plant.hpp"
#include "sinew/sim/wire/station.hpp"

#include <cstdint>
#include <limits>
#include <string_view>

namespace sinew::sim {

/// One value that a device keeps without power.
struct KeptValue {
    std::string_view key;
    std::int64_t value = 0;
};

/// What a device is doing, for people to look at.
struct Look {
    double position_rad = 0.0;
    double velocity_rad_s = 0.0;
    std::string_view mode;       ///< "position", "passive", … in the family's own words; "off" without power
    double current_a = 0.0;      ///< of the winding
    double voltage_v = 0.0;      ///< of the supply
    double temperature_c = 25.0; ///< what the device would say
    std::string_view faults{};   ///< "overload", "hot", …: what its firmware complains about; empty: nothing
};

/// One simulated device: messages in, answers out, with the plant it turns. It knows no wire and no bus. Whoever owns
/// it moves it on by `run`, one tick of `tick` at a time. Single-threaded; `run` and `hear` allocate nothing.
class Device : public Station
{
public:
    Device(const PlantParameters& plant, double start_rad) : plant_(plant, start_rad) {}

    Look look() const;

    virtual std::uint32_t flash_writes() const = 0; ///< write commands so far
    /// What it keeps without power, for a flash file; asks the heap for memory.
    virtual std::vector<KeptValue> kept() const = 0;
    /// Puts that back as if it had never been away, and starts afresh. `bad_file`: nothing is changed.
    virtual std::expected<void, Error> restore(const config::FlashFile& file, const config::FlashJoint& joint) = 0;

    /// One tick at this supply voltage: the control loop, then ten steps of the plant. Below `runs_above_v` the device
    /// is off, its motor open; it starts afresh when the voltage comes back.
    void run(double supply_v);
    /// Off and on within no time: what is not in flash is lost.
    void power_cycle();
    double supply_current_a() const { return plant_.supply_current_a() + (is_on_ ? idle_a : 0.0); }

    // ---- what may happen to it ----

    /// Pulled from its cable, with power and data; and put back.
    void unplug() { is_plugged_ = false; }
    void plug() { is_plugged_ = true; }
    bool is_plugged() const { return is_plugged_; }
    /// Its supply gives no more than this; infinity: as it was.
    void limit_supply(double voltage_v) { supply_most_v_ = voltage_v; }
    /// It is spoken to by this id, whatever its settings say; -1: as they say.
    void force_id(int id) { forced_id_ = id; }
    int id() const final { return forced_id_ >= 0 ? forced_id_ : set_id(); }
    /// Its transceiver works at this rate, whatever its settings say; 0: as they say.
    void force_bit_rate(std::uint32_t bit_rate) { forced_bit_rate_ = bit_rate; }
    Plant& plant() { return plant_; }
    const Plant& plant() const { return plant_; }

    bool is_on() const { return is_on_; }
    std::uint32_t bit_rate() const final
    {
        if (!is_on_)
            return 0;
        return forced_bit_rate_ != 0 ? forced_bit_rate_ : set_bit_rate();
    }

    static constexpr double runs_above_v = 5.0; ///< ASSUMED: what the controller needs
    static constexpr double idle_a = 0.04;      ///< ASSUMED: what the electronics take

protected:
    virtual void power_on() = 0;
    virtual void control() = 0; ///< once a tick, while it is on: looks at the plant and drives its motor
    virtual std::uint32_t set_bit_rate() const = 0;
    virtual int set_id() const = 0;
    virtual void tell(Look& look) const = 0; ///< mode, temperature and faults, while it is on
    double supply_v() const { return supply_v_; }

    Plant plant_;

private:
    double supply_v_ = 0.0;
    double supply_most_v_ = std::numeric_limits<double>::infinity();
    std::uint32_t forced_bit_rate_ = 0;
    int forced_id_ = -1;
    bool is_on_ = false;
    bool is_plugged_ = true;
};

} // namespace sinew::sim
