#pragma once
#include "sinew/family/sam/messages.hpp"
#include "sinew/wire/values.hpp"
#include "tests/robot/rig.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// Reads every frame that leaves the host, with scales of its own, and holds it against the limits of the joint. A
/// position is held against where the shaft is, where it was measured and where it was sent: there is no slack but the
/// step of an encoder. How far what is believed may be from the truth is for who watches the shafts.
namespace sinew::robot::test {

class Watch
{
public:
    explicit Watch(Rig& rig) : rig_(rig)
    {
        for (bus::Bus* bus : rig.robot->buses())
            bus->set_tap([this, bus](const bus::Tapped& tapped) {
                if (tapped.verdict == bus::Verdict::sent)
                    sent(*bus, tapped);
                if (each_frame)
                    each_frame();
            });
    }

    /// Positions are planned for the beginning of a cycle, whenever their frames have their turn on the line.
    void cycle_begins() { cycle_at_ = rig_.now(); }
    /// From now on until the next cycle the robot runs itself, and nobody says when an exchange is planned.
    void runs_itself()
    {
        cycle_at_.reset();
        run_at_ = rig_.now();
    }
    std::function<void()> each_frame;
    const std::vector<std::string>& complaints() const { return complaints_; }
    std::size_t motions() const { return motions_; }

private:
    struct Target {
        double position_rad = 0.0;
        TimePoint planned_at{}; ///< when it changed last: no earlier
        TimePoint sent_at{};    ///< at all
        bool is_streamed = false;
    };

    static constexpr std::uint32_t torque_group = 0x280;
    /// What these say is looked at below, or takes drive away.
    static inline const std::set<std::string_view> judged{"position-control",
                                                          "precise-position-control",
                                                          "quick-position-control",
                                                          "special-control",
                                                          "position-speed-control",
                                                          "accel-position-control",
                                                          "accel-speed-control",
                                                          "set-control-on-off",
                                                          "multi-loop-angle",
                                                          "multi-loop-angle-speed",
                                                          "speed-closed-loop",
                                                          "torque-closed-loop",
                                                          "motor-running",
                                                          "motor-off",
                                                          "motor-stop",
                                                          "brake-control",
                                                          "brake-release"};

    static double number(const wire::Values& values, std::string_view name)
    {
        return static_cast<double>(values.find(name).value_or(0));
    }

    void sent(const bus::Bus& bus, const bus::Tapped& tapped)
    {
        wire::Frame frame{.can_id = tapped.can_id, .size = static_cast<std::uint8_t>(tapped.bytes.size())};
        std::ranges::copy(tapped.bytes, frame.data.begin());
        if (frame.can_id == torque_group)
            return look_at_group(bus, frame);
        const int id = bus.protocol().addressee(frame);
        for (Joint& joint : rig_.robot->joints()) {
            if (joint.bus() != bus.name() || id_of(joint.device()) != id)
                continue;
            const auto* message = bus.protocol().identify(frame, wire::Direction::request, line_of(joint.device()));
            ASSERT_NE(message, nullptr);
            const auto said = wire::decode(*message, wire::Direction::request, frame, options_of(joint.device()));
            ASSERT_TRUE(said.has_value());
            is_stop_ = is_of_stop(bus, frame);
            const std::size_t places = places_;
            if (message->info.moves && !judged.contains(message->name()))
                complain(joint, message->name(), 0.0);
            look(joint, message->name(), said->values, tapped.at);
            // Whatever else it is told takes it away from where it was sent.
            if (places == places_ && message->info.access != wire::Access::read)
                placed_.erase(&joint);
        }
    }

    /// What a bus sends when another one has lost its link.
    bool is_of_stop(const bus::Bus& bus, const wire::Frame& frame) const
    {
        const auto buses = rig_.robot->buses();
        for (std::size_t i = 0; i < buses.size(); ++i)
            if (buses[i] == &bus)
                return std::ranges::any_of(rig_.robot->stop_requests(i),
                                           [&](const wire::Request& request) { return request.frame == frame; });
        return false;
    }

    void look(Joint& joint, std::string_view message, const wire::Values& values, TimePoint at)
    {
        if (const auto* spec = std::get_if<sam::Spec>(&joint.device()))
            look_at_sam(joint, *spec, message, values, at);
        else if (std::holds_alternative<nuri::Spec>(joint.device()))
            look_at_nuri(joint, message, values);
        else
            look_at_rmd(joint, message, values);
    }

    void look_at_sam(Joint& joint, const sam::Spec& spec, std::string_view message, const wire::Values& values,
                     TimePoint at)
    {
        const auto* scale = message == "precise-position-control" ? &*spec.model->precise
                            : message == "position-control"       ? &spec.model->standard
                            : message == "quick-position-control" ? &spec.model->quick
                                                                  : nullptr;
        if (scale != nullptr)
            stream(joint, scale->rad(number(values, "target_position")), units::rad(scale->deg_per_unit), at);
        if (message != "special-control")
            return;
        targets_[&joint].is_streamed = false;
        if (number(values, "mode") == static_cast<double>(sam::Mode::wheel))
            velocity(joint,
                     std::fmod(number(values, "wheel_speed"), 1000.0) / 1000.0 * spec.model->ratings.max_speed_rad_s,
                     spec.model->ratings.max_speed_rad_s / 1000.0);
    }

    /// The currents of ids 1 to 4: 2000 is 32 A.
    void look_at_group(const bus::Bus& bus, const wire::Frame& frame)
    {
        for (Joint& joint : rig_.robot->joints()) {
            const auto at = 2 * static_cast<std::size_t>(id_of(joint.device()) - 1);
            if (joint.bus() != bus.name() || at >= frame.size)
                continue;
            const auto raw = static_cast<std::int16_t>(frame.data[at] | frame.data[at + 1] << 8);
            current(joint, 0.016 * raw, 0.016);
            placed_.erase(&joint);
        }
    }

    void look_at_nuri(Joint& joint, std::string_view message, const wire::Values& values)
    {
        const double sense = number(values, "position_direction") == 0.0 ? 1.0 : -1.0;
        const double position = sense * units::rad(number(values, "position") * 0.01);
        if (message == "position-speed-control" || message == "accel-position-control")
            place(joint, position, units::rad(0.01));
        if (message == "accel-position-control" && joint.state().position_rad)
            velocity(joint,
                     std::abs(position - Mounting::of(joint.file()).to_actuator(*joint.state().position_rad)) /
                         (0.1 * number(values, "arrival_time")),
                     0.0);
        if (message == "position-speed-control" || message == "accel-speed-control")
            velocity(joint, units::rad_s_from_rpm(number(values, "speed") * 0.1), 0.0);
    }

    void look_at_rmd(Joint& joint, std::string_view message, const wire::Values& values)
    {
        if (message == "multi-loop-angle" || message == "multi-loop-angle-speed")
            place(joint, units::rad(number(values, "angle") * 0.01), units::rad(0.01));
        if (message == "multi-loop-angle-speed") {
            const double unit =
                units::rad(joint.file().profile->value == "lk-2.35" ? 1.0 : 0.01); // R01: of a profile that is named
            velocity(joint, unit * number(values, "max_speed"), unit);
        }
        if (message == "speed-closed-loop")
            velocity(joint, std::abs(units::rad(number(values, "speed") * 0.01)), units::rad(0.01));
        if (message == "torque-closed-loop") {
            const double a_unit = (std::get<rmd::Spec>(joint.device()).model->name == "MF" ? 16.5 : 33.0) / 2048.0;
            current(joint, a_unit * number(values, "iq"), a_unit);
        }
    }

    void current(const Joint& joint, double a, double step)
    {
        ++motions_;
        if (joint.limits().current_max_a && std::abs(a) > *joint.limits().current_max_a + step)
            complain(joint, "current", a);
    }

    /// How far the shaft is from there, or was when it was measured; whole turns of an encoder that counts none do not
    /// count.
    double apart(const Joint& joint, double position_rad)
    {
        const double way = position_rad - rig_.truth_rad(joint);
        const bool counts = !std::holds_alternative<sam::Spec>(joint.device());
        const double now = std::abs(counts ? way : std::remainder(way, 2.0 * std::numbers::pi));
        // A joint that is set up anew begins there, without a frame that says so.
        return std::min(now, std::abs(position_rad - *joint.state().position_rad));
    }

    /// To hold where it stands is no command beyond a limit.
    bool may_be_anywhere(const Joint& joint) const
    {
        return is_stop_ || !rig_.robot->enabled() || joint.command().mode == Mode::hold;
    }

    void place(Joint& joint, double actuator_rad, double step)
    {
        ++motions_;
        ++places_;
        const double position = Mounting::of(joint.file()).to_joint(actuator_rad);
        const double beyond = beyond_rad(joint, position);
        const auto known = placed_.find(&joint);
        const double before = known != placed_.end() ? known->second : std::nan("");
        placed_[&joint] = position;
        const bool stands = may_be_anywhere(joint) && apart(joint, position) < units::rad(30);
        if (beyond > step && !stands && !leads_back(joint, position, before, step))
            complain(joint, "position", units::deg(position));
    }

    /// How far that is beyond the limits; 0: within.
    static double beyond_rad(const Joint& joint, double position_rad)
    {
        const auto& limits = joint.limits();
        const double low = limits.position_low_rad ? *limits.position_low_rad - position_rad : 0.0;
        const double high = limits.position_high_rad ? position_rad - *limits.position_high_rad : 0.0;
        return std::max({low, high, 0.0});
    }

    /// From beyond a limit a joint may be sent back, a part of the way, too: no further out than it stands, stood when
    /// it was measured, or was sent just before (NaN: nowhere).
    bool leads_back(const Joint& joint, double position_rad, double before_rad, double step) const
    {
        const bool is_low = joint.limits().position_low_rad && position_rad < *joint.limits().position_low_rad;
        const auto is_as_far = [&](double from_rad) {
            return is_low ? from_rad <= position_rad + step : from_rad >= position_rad - step;
        };
        return is_as_far(rig_.truth_rad(joint)) || is_as_far(*joint.state().position_rad) || is_as_far(before_rad);
    }

    void velocity(Joint& joint, double actuator_rad_s, double step)
    {
        ++motions_;
        const double speed = actuator_rad_s / joint.file().ratio;
        if (joint.limits().velocity_max_rad_s && speed > *joint.limits().velocity_max_rad_s + step + 1e-9)
            complain(joint, "velocity", units::deg(speed));
    }

    /// A position that the device goes to as fast as it can. What was sent while the robot runs itself was planned no
    /// earlier than the frame before.
    void stream(Joint& joint, double actuator_rad, double step, TimePoint at)
    {
        place(joint, actuator_rad, step);
        const double position = Mounting::of(joint.file()).to_joint(actuator_rad);
        Target& last = targets_[&joint];
        const bool is_streamed = !is_stop_ && joint.command().mode == Mode::position && rig_.robot->enabled();
        const TimePoint before = std::exchange(last.sent_at, at);
        if (last.position_rad != position || !is_streamed) {
            const Duration gap =
                std::min<Duration>(cycle_at_.value_or(at) - last.planned_at, std::chrono::milliseconds{50});
            const double most =
                joint.limits().velocity_max_rad_s.value_or(1e9) * seconds(gap + Supervisor::unrest) + 2.0 * step;
            // What was planned from the measured position may never have left because a link was lost.
            const double way = std::min(std::abs(position - last.position_rad), apart(joint, position));
            if (is_streamed && last.is_streamed && way > most)
                complain(joint, "step", units::deg(way));
            last = {position, cycle_at_.value_or(std::max(before, run_at_)), at, is_streamed};
        }
    }

    void complain(const Joint& joint, std::string_view what, double value)
    {
        complaints_.push_back(fmt::format("{}: {} {:.3f} left the host in mode {}", joint.name(), what, value,
                                          to_word(joint.command().mode)));
    }

    Rig& rig_;
    std::optional<TimePoint> cycle_at_; ///< nobody knows while the robot runs itself
    TimePoint run_at_{};
    bool is_stop_ = false;
    std::map<const Joint*, Target> targets_;
    std::map<const Joint*, double> placed_; ///< by its last command, where that was a place
    std::size_t places_ = 0;
    std::vector<std::string> complaints_;
    std::size_t motions_ = 0;
};

} // namespace sinew::robot::test
