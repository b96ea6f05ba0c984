#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/base/error.hpp"
#include "sinew/robot/following.hpp"

#include <cstdint>
#include <expected>
#include <optional>
#include <string>

namespace sinew::robot {

/// What one joint is held to, in the units of the joint.
struct Rules {
    actuator::Limits limits;
    std::optional<Duration> command_timeout; ///< a command that nobody renews for so long is over
    Duration silence_max{};                  ///< so long a device may give no answer, or none that tells its place
    Duration stop_time{};                    ///< in which it surely comes to rest after it was told to hold
    std::optional<double> lead_max_rad;      ///< so far a streamed position may be ahead of the shaft
    double trail_rad = 0.0;                  ///< so far it is at the greatest velocity
    std::optional<double> torque_constant_nm_per_a; ///< of the joint, where it is known
};

/// What must be done about a joint.
enum class Measure : std::uint8_t {
    none,
    end, ///< the command is over: at a limit it holds, without commands it does what the policy says
    stop ///< a fault: stop
};

struct Finding {
    Measure measure = Measure::none;
    Error why{}; ///< one sentence; empty where there is nothing to do
};

/// Keeps one joint within its limits, whatever the program does. Pure: states, commands and time points go in, verdicts
/// come out. No heap but for the sentence of an error. It never changes a value: what is beyond a limit is refused.
///
/// A position that is to be reached at once may be no further from the last one than the joint may turn in the time
/// between, counted up to `longest_gap`, and `unrest` of the loop. The first is counted from the measured position, so
/// nothing ever jumps. Nor may it be further ahead of the shaft than `lead_max_rad` and what the joint may turn in the
/// age of its measurement: what does not follow is not led on, or it would leap when it comes free. While it comes, it
/// is led on from half of that, lest it go on too fast.
class Supervisor
{
public:
    Supervisor() = default;
    /// `limits_velocity`: the device itself keeps moves to a velocity.
    Supervisor(std::string joint, int id, Rules rules, bool limits_velocity);

    static constexpr Duration longest_gap = std::chrono::milliseconds{50};
    static constexpr Duration unrest = std::chrono::milliseconds{5};
    /// A measured velocity or current counts when it lasts for so long.
    static constexpr Duration lasting = std::chrono::milliseconds{100};
    static constexpr double velocity_tolerance = 1.25; ///< times the limit: what a control loop overshoots
    /// At its lead and no further for so long, a joint that is led counts as blocked.
    static constexpr Duration patience = Following::patience;

    /// From now on it begins where the joint was measured. A joint that stands beyond a limit may stay there and come
    /// back; it may go no further.
    void begin(const actuator::State& state, TimePoint now);

    /// Whether a command, in joint units, may be carried out from this state. A move that names no velocity gets the
    /// greatest one where the device keeps to it. From beyond a limit every position is allowed that leads back, and
    /// none that leads further out. `out_of_range` and `unsupported` with the limit and the value.
    std::expected<actuator::Command, Error> admit(const actuator::Command& command, const actuator::State& state,
                                                  TimePoint now) const;
    /// The position nearest to this one that leads no further beyond a limit, seen from this state. What was admitted
    /// goes out later, and by then a joint that was on its way back is further in.
    double nearest_allowed_rad(double position_rad, const actuator::State& state) const;
    /// The position nearest to this one that may be reached at once now, as far as steps and the lead go: for streams,
    /// which a late loop must not end.
    double nearest_step_rad(double position_rad, TimePoint now) const;
    /// The same as far as the lead goes. It takes a joint back, towards its shaft, only where that leaps: where it has
    /// come free and turns too fast.
    double nearest_lead_rad(double position_rad, TimePoint now) const;
    /// Whether the shaft is further away from this position than it may be led.
    bool is_behind(double position_rad, TimePoint now) const;
    /// The position that is being sent in this cycle.
    void sent(double position_rad, TimePoint now);
    /// No position is sent in this cycle; it is here.
    void follow(double position_rad, TimePoint now);
    /// What begins now begins at the newest measurement, unless a position was sent.
    void catch_up(const actuator::State& state, TimePoint now);
    /// The position that moves begin at: the last that was sent, else the last that was measured.
    const std::optional<double>& reference_rad() const { return reference_rad_; }

    /// A new measurement.
    void observe(const actuator::State& state);
    /// What is to be done, while `running` is carried out since `commanded`. `answered`: when the device last answered;
    /// `interval`: between two cycles.
    Finding judge(const actuator::State& state, const actuator::Command& running, TimePoint commanded,
                  TimePoint answered, Duration interval, TimePoint now);

    /// Whether positions are held to their limits: not while a joint looks for its reference.
    void watch_place(bool on) { watches_place_ = on; }
    /// How far the joint can go on from this velocity until it stands still, when it is looked at in this interval.
    double stopping_distance_rad(double velocity_rad_s, Duration interval) const;
    /// As measured, or as the positions tell where that is newer. Without a sign of its own where nothing is known: 0.
    double velocity_rad_s() const { return velocity_rad_s_; }
    const Rules& rules() const { return rules_; }

private:
    /// What is less than this beside a limit, in whatever unit, is the rounding of a conversion.
    static constexpr double noise_rad = 1e-9;

    struct Reach {
        std::optional<double> low_rad, high_rad;
    };

    std::unexpected<Error> refuse(Errc code, std::string why) const;
    Finding finding(Measure measure, Errc code, std::string why) const;
    std::expected<void, Error> check_step(const actuator::Command& command, TimePoint now) const;
    std::expected<void, Error> check_sense(const actuator::Command& command, const actuator::State& state) const;
    std::expected<void, Error> check_push(const actuator::Command& command) const;
    double allowance_rad(TimePoint now) const;
    double lead_rad(TimePoint now) const;
    double within_lead_rad(double position_rad, TimePoint now) const;
    bool leaps() const;
    void refer_to(double position_rad, bool is_commanded, TimePoint now);
    Finding judge_silence(const actuator::Command& running, TimePoint answered, TimePoint now) const;
    Finding judge_faults(const actuator::State& state) const;
    Finding judge_excess(const actuator::State& state);
    Finding judge_place(const actuator::State& state, const actuator::Command& running, Duration interval,
                        TimePoint now) const;
    Finding judge_lead(const actuator::Command& running);
    void see_whether_it_comes();
    Reach allowed(const actuator::State& state) const;
    void see_where_it_stands();
    bool lasts(std::optional<TimePoint>& since, bool too_much, TimePoint at);

    std::string joint_;
    int id_ = -1;
    Rules rules_;
    bool limits_velocity_ = false;
    bool watches_place_ = true;
    Reach reach_; ///< the limits, widened to where it began
    std::optional<double> reference_rad_;
    TimePoint reference_at_{};
    bool is_commanded_ = false;  ///< the reference
    double allowance_rad_ = 0.0; ///< at `reference_at_`
    actuator::Measured<double> seen_;
    TimePoint placed_at_{}; ///< its position was measured last, or was not asked for before
    double velocity_rad_s_ = 0.0;
    double fastest_rad_s_ = 0.0; ///< of late, for how far it may still be going
    std::optional<TimePoint> too_fast_since_, too_strong_since_;
    Following following_;
    bool comes_ = false;              ///< from where its lead had ended
    actuator::Measured<double> mark_; ///< where it was when it last got on
    std::optional<double>
        stood_rad_; ///< where its lead ended, at the furthest, until it is no further ahead than usual
};

} // namespace sinew::robot
