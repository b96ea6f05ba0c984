#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/config/robot_file.hpp"
#include "sinew/robot/synchronised.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::robot {

/// "the current of gripper is above 0.3 A", with "is" as the verb.
std::string to_words(const config::RobotFile& file, const config::Condition& condition, std::string_view verb);

/// Plays a sequence of a robot file: states and time go in, targets come out. Pure: no I/O, no clock of its own, no
/// heap after it was made but for the sentence of an error. One thread.
///
///     SequencePlayer player(file, sequence);
///     while (player.next(clock.now(), states) == SequencePlayer::Status::running)
///         send(player.targets());
///     send(player.targets()); // the last ones
///
/// A joint starts where it was measured, or where the player has sent it last, and what is cut short slows down as
/// fast as its joint may. When the loop is late the motion waits for it: between two calls it goes on by `longest_step`
/// at most, so that no target ever jumps.
class SequencePlayer
{
public:
    enum class Status : std::uint8_t {
        running,
        done,
        stopped, ///< by `stop`
        failed,  ///< see `error`
    };
    static constexpr Duration longest_step = std::chrono::milliseconds{50};

    /// One joint of the motion that is on its way.
    struct Moving {
        std::size_t joint = 0; ///< of the robot file
        Trajectory way;
    };

    /// File and sequence must outlive it; the sequence is one of the file, or calls none.
    /// `speed`: share of the fastest motions, above 0 up to 1.
    SequencePlayer(const config::RobotFile& file, const config::Sequence& sequence, double speed = 1.0);

    /// What is to be done now. `states`: of all joints in the order of the file, in joint units. After the end it says
    /// the same again.
    Status next(TimePoint now, std::span<const actuator::State> states);
    /// Ends it from the next call on: what moves slows down first.
    void stop() { stop_asked_ = true; }

    /// The next call does not go on, for joints that have fallen behind; only the patience of a condition goes on.
    void wait() { waits_ = true; }
    /// How much later the sequence is than planned, by a late loop and by `wait`.
    Duration delayed() const { return delayed_; }

    /// Where each joint of the file is to be now; nothing: the sequence has not moved it yet.
    std::span<const std::optional<Setpoint>> targets() const { return targets_; }
    /// The motion on its way, for devices that can plan one themselves; empty: all stand.
    std::span<const Moving> moving() const { return moving_; }
    /// Counts the motions that began, those that slow down early included: a new number is a new `moving`.
    std::uint64_t motions() const { return motions_; }
    /// Whether the motion on its way is the end of another one.
    bool slowing_down() const { return phase_ == Phase::slowing_down; }

    /// The step that is carried out; nullptr: none.
    const config::Step* step() const { return step_; }
    std::uint64_t steps_begun() const { return steps_begun_; }
    /// Why it failed, with the place in the robot file: `out_of_range` for a duration that is too short, `timeout` for
    /// a condition that was not met, `bad_argument` for a joint whose position was never measured.
    const Error& error() const { return error_; }

private:
    enum class Phase : std::uint8_t { between, carrying_out, slowing_down, ended };
    struct Frame {
        const std::vector<config::Step>* steps = nullptr;
        std::size_t next = 0;
        std::optional<std::int64_t> more; ///< passes after this one; nothing: for ever
    };

    using States = std::span<const actuator::State>;

    void enter(const std::vector<config::Step>& steps, std::optional<std::int64_t> times);
    void begin_next(States states);
    std::expected<void, Error> begin_move(const config::Step& step, States states);
    void carry_on(States states);
    bool is_met(const config::Condition& condition, States states) const;
    Error not_met(const config::Condition& condition, States states) const;
    void finish_step(Duration at);
    void go_on(Duration at);
    void slow_down(Status then);
    void settle();
    void fail(Error error);
    void end(Status status);
    Error at_step(Errc code, std::string_view says) const;

    const config::RobotFile* file_;
    double speed_ = 1.0;
    std::array<Frame, config::deepest_nesting> frames_{};
    std::size_t depth_ = 0;
    Phase phase_ = Phase::between;
    Status status_ = Status::running;
    Status then_ = Status::running; ///< after slowing down
    bool stop_asked_ = false;
    Error error_{};

    std::optional<TimePoint> called_at_;
    TimePoint step_call_at_{}; ///< the call in which the step began: older measurements say nothing about it
    bool waits_ = false;
    Duration delayed_{}, waited_{};
    Duration step_waited_{}; ///< `waited_` when the step began
    Duration time_{};        ///< of the sequence: stands still while the loop is late
    Duration step_begun_{}, motion_begun_{}, motion_duration_{}; ///< in that time

    const config::Step* step_ = nullptr;
    std::uint64_t motions_ = 0, steps_begun_ = 0;
    Synchronised plan_;
    std::vector<JointMotion> wanted_;
    std::vector<Moving> moving_;
    std::vector<std::optional<Setpoint>> targets_;
};

} // namespace sinew::robot
