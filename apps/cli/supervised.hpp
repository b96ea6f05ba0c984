#pragma once
#include "apps/cli/rest.hpp"
#include "sinew/robot/supervisor.hpp"

/// What the supervisor of a robot's joints does, for one device that a verb drives: `move`, `home`, `tune` and `jog`.
namespace sinew::cli {

/// How a position may be reached at once.
enum class Reached {
    in_steps,  ///< no step is longer than `velocity_max_deg_s` allows
    by_a_leap, ///< only `step_max_deg` counts: whoever measures a step wants to see it
};

/// Holds one device to the limits of the robot file: what is sent, and what is measured. The device must have been read
/// wholly; nothing is sent before `send`. In joint units.
class Supervised
{
public:
    Supervised(Session& session, Driven& driven, Reached reached = Reached::in_steps);

    /// Carries it out if it is within the limits and nothing is wrong with the device; then that is what runs. Where it
    /// is not acknowledged `look` sends it again. A device whose answers are missing is told nothing more until it
    /// answers.
    std::expected<void, Error> send(const actuator::Command& command);
    /// A velocity by which it looks for its stop, which may be beyond a limit: its place is watched no more.
    std::expected<void, Error> search(double velocity_rad_s);
    /// It was brought to rest by other hands.
    void rests();
    /// Whether anything has been, acknowledged or not: else an error has moved nothing.
    bool has_sent() const { return has_sent_; }
    /// Reads it, now and then wholly. An error where what was measured may not go on; of a limit of the robot file it
    /// is `out_of_range`. Answers may be missing for `silence_max_s`, and the state is empty then; one that comes after
    /// so long that the device may have lost its supply is an error as well.
    std::expected<void, Error> look();
    /// Whether the last answer is missing, and it should be looked at soon.
    bool is_missing() const { return missing_since_.has_value(); }
    /// The position that moves begin at: the last that was sent, else the last that was measured.
    std::optional<double> reference_rad() const { return guard_.reference_rad(); }
    /// The position nearest to this one that may be sent now: no step is too long, and what does not follow is not led
    /// on.
    double nearest_step_rad(double position_rad) const;

private:
    /// What was not acknowledged.
    struct Unheard {
        wire::Requests requests;
        TimePoint since;
    };

    actuator::State state() const;
    std::expected<void, Error> judge(Duration interval);
    std::expected<void, Error> begin(const actuator::Command& command);
    std::expected<void, Error> tell(const wire::Requests& requests);
    std::expected<void, Error> answers_again();
    std::expected<void, Error> tell_again();

    Session& session_;
    Driven& driven_;
    robot::Supervisor guard_;
    Duration between_full_;
    actuator::Command running_{.mode = actuator::Mode::hold};
    bool has_sent_ = false;
    TimePoint answered_at_;
    TimePoint looked_at_;
    TimePoint full_at_;                      ///< the next full reading is due
    std::optional<TimePoint> missing_since_; ///< an answer
    std::optional<Unheard> unheard_;
};

/// The end of a motion for an error: it comes to rest. That it came to a limit is said here, and has an exit code of
/// its own; `before_words` is called when it is at rest, and nothing is written before.
Outcome stopped_for(Session& session, Driven& driven, const Error& why, Otherwise otherwise = Otherwise::nothing,
                    const std::function<void()>& before_words = {});

} // namespace sinew::cli
