#pragma once
#include "tests/robot/by_hand.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <string_view>
#include <utility>

/// Servos that carry a load: what a servo holds with gives way to it.
namespace sinew::robot::test {

using namespace std::chrono_literals;

/// An arm that carries so much, and servos that carry nothing on its bus or on another one.
struct Servos {
    int others = 0;
    int bit_rate = 1'500'000;
    double gravity_torque_nm = 0.0;
    int bit_rate_of_others = 0; ///< they have a bus of their own
    int rate_hz = 0;
};

inline std::string file_text(const Servos& servos)
{
    const auto bus = [](std::string_view name, int bit_rate) {
        return fmt::format("[bus.{}]\nfamily = \"sam\"\nbit_rate = {}\n", name, bit_rate);
    };
    const auto servo = [](std::string_view name, std::string_view of, int id) {
        return fmt::format("[joint.{}]\nbus = \"{}\"\nid = {}\nmodel = \"SAM-20\"\n", name, of, id);
    };
    std::string text = "version = 1\n" + bus("s", servos.bit_rate);
    if (servos.rate_hz != 0)
        text += fmt::format("rate_hz = {}\n", servos.rate_hz);
    if (servos.bit_rate_of_others != 0)
        text += bus("t", servos.bit_rate_of_others);
    text += servo("arm", "s", 1) + fmt::format("[joint.arm.plant]\ngravity_torque_nm = {}\ngravity_zero_deg = -60\n",
                                               servos.gravity_torque_nm);
    for (int id = 2; id < 2 + servos.others; ++id)
        text += servo(fmt::format("j{}", id), servos.bit_rate_of_others != 0 ? "t" : "s", id);
    return text;
}

/// How far the arm goes from where it was, and all of its way, at every frame of its bus.
class Way
{
public:
    explicit Way(Rig& rig) : rig_(rig), from_(rig.truth_rad("arm")), before_(from_)
    {
        rig.robot->buses()[0]->set_tap([this](const bus::Tapped&) { look(); });
    }
    ~Way() { rig_.robot->buses()[0]->set_tap({}); }
    void look()
    {
        const double now = rig_.truth_rad("arm");
        furthest_ = std::max(furthest_, std::abs(now - from_));
        all_ += std::abs(now - std::exchange(before_, now));
    }
    double furthest_deg() const { return units::deg(furthest_); }
    double all_deg() const { return units::deg(all_); }

private:
    Rig& rig_;
    double from_, before_, furthest_ = 0.0, all_ = 0.0;
};

/// How often the arm is braked.
class Brakes
{
public:
    explicit Brakes(Rig& rig) : rig_(rig)
    {
        rig.robot->buses()[0]->set_tap([this](const bus::Tapped&) { look(); });
    }
    ~Brakes() { rig_.robot->buses()[0]->set_tap({}); }
    void look()
    {
        const bool is_braked = rig_.simulator->world().look("arm")->mode == "brake";
        times_ += is_braked && !was_braked_ ? 1 : 0;
        was_braked_ = is_braked;
    }
    int times() const { return times_; }

private:
    Rig& rig_;
    bool was_braked_ = false;
    int times_ = 0;
};

inline void cycle(Rig& rig, int times)
{
    for (int i = 0; i < times; ++i) {
        (void)rig.robot->cycle();
        wait(*rig.simulator, 10ms);
    }
}

} // namespace sinew::robot::test
