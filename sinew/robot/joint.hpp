#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/families.hpp"
#include "sinew/link/clock.hpp"
#include "sinew/robot/drive.hpp"
#include "sinew/robot/incidents.hpp"
#include "sinew/robot/mounting.hpp"
#include "sinew/robot/stillness.hpp"
#include "sinew/robot/supervisor.hpp"

#include <memory>
#include <string>

/// The joints of a robot file in motion, in radians and by name.
namespace sinew::robot {

using actuator::Command;
using actuator::Depth;
using actuator::Mode;
using actuator::State;

/// One actuator by its name. All values are those of the joint: direction, zero and ratio of the robot file are in
/// them. It belongs to its `Robot` and is used from the thread that drives it.
class Joint
{
public:
    const std::string& name() const { return resolved_->joint->name; }
    const config::Joint& file() const { return *resolved_->joint; }
    const std::string& bus() const { return resolved_->bus->name; }
    const Family& family() const { return *resolved_->family; }
    const DeviceSpec& device() const { return resolved_->device; }
    const actuator::Capabilities& capabilities() const { return can_; }
    const actuator::Limits& limits() const { return guard_.rules().limits; }

    /// What the next cycle sends, and every one after it. A wrong command is an error and changes nothing: the one
    /// before stays. To say the same again renews it (`command_timeout_s`).
    ///
    /// - Position without velocity: at once, as far as the greatest velocity allows; see `Supervisor`.
    /// - Position with a velocity or a duration: where the device does not do that itself the robot walks there, a step
    ///   a cycle.
    std::expected<void, Error> set(const Command& command);
    /// The command stands as it is: counts as said again.
    void renew() { commanded_at_ = now(); }
    const Command& command() const { return command_; }
    /// The position nearest to this one that `set` would take without a velocity now: what lies further is reached in
    /// the cycles after.
    double nearest_step_rad(double position_rad) const { return guard_.nearest_step_rad(position_rad, now()); }
    /// Whether it has fallen so far behind this position that it must not be led on.
    bool is_behind(double position_rad) const { return guard_.is_behind(position_rad, now()); }

    /// What was measured last, each value with its time.
    const State& state() const { return state_; }
    /// The same in the units of the actuator.
    const State& actuator_state() const { return raw_; }
    /// How long the device has given no answer; as long as the robot is there where it never did.
    Duration silent_for() const { return now() - answered_at_; }
    /// Exchanges of this joint that failed since the robot was opened.
    std::uint64_t failures() const { return failures_; }
    /// Why the latest of them failed, or the latest command was not carried out; nullptr: nothing ever was wrong.
    const Error* trouble() const { return trouble_ ? &*trouble_ : nullptr; }
    /// How often the robot itself has put another command in the place of the one that was set: at a limit, without
    /// commands, after a silence, a fault or a reset.
    std::uint64_t overruled() const { return overruled_; }
    /// Why, the last time; nullptr: never.
    const Error* overruled_by() const { return overruled_by_ ? &*overruled_by_ : nullptr; }

    /// Whether position 0 is where the robot file says: a SAM knows its angle always, an RMD within its first turn (0 …
    /// 360 deg). A Nuri, and an RMD that may stand in another turn, must be taken `home`; an LK motor of which that is
    /// so again when it was released or braked, for it loses its turns by that.
    bool referenced() const { return referenced_; }

    // ---- for the robot ----

    /// It has not confirmed the last stop.
    bool owes_stop() const { return owes_stop_; }
    Joint(const ResolvedJoint& resolved, const config::RobotFile& file, const link::Clock& clock, Incidents& incidents);

private:
    friend class Line;
    friend class LoadOfLine;
    friend class Core;

    TimePoint now() const { return clock_->now(); }
    static bool same(const Command& a, const Command& b);
    Error named(Error error) const;
    void take(const Command& command, TimePoint at);
    void hold_here(TimePoint at);
    void come_to_rest(Mode how, TimePoint at);
    void end(TimePoint at);
    void overrule(Error why);
    /// What it knows after power-on is left of where it stands.
    void forget_reference() { referenced_ = is_absolute_; }
    void start_afresh(std::string why, TimePoint at);
    void begin(TimePoint at);
    std::expected<void, Error> check_open() const;
    std::expected<void, Error> check_search() const;
    void begin_search();
    void end_search();
    bool let_go_again();
    Command next(TimePoint at);
    void rest_of_move(Command& command, TimePoint at) const;
    bool must_send(const Command& command, TimePoint at) const;
    bool has_let_go() const;
    bool may_send(TimePoint at) const;
    /// After an exchange: nothing of what it was told last is still to be sent, for all that its answers say.
    void see_whether_it_has_heard()
    {
        has_heard_ = !fresh_ && repetitions_ == 0 && !must_relieve_ && !may_press_on_ && !slowing_ && !missing_since_ &&
                     answered_at_ >= planned_at_;
    }
    std::expected<wire::Requests, Error> plan_look(double resolution_rad);
    void begin_where_it_is(TimePoint at);
    /// In the units of the actuator.
    void went_out(const Command& own, TimePoint at);
    std::expected<wire::Requests, Error> plan(TimePoint at, double resolution_rad);
    /// `unseen`: nobody knows what has happened to the shaft since it was measured, such as while its link was lost.
    std::expected<wire::Requests, Error> plan_policy(actuator::Driver& driver, bool unseen) const;
    /// Whether to be told to hold takes no torque from what blocks it.
    bool presses() const;
    void see_whether_it_turns_freely(TimePoint at);
    /// Before it is told to hold.
    void note_whether_it_turns();
    /// Whether it turned then, stands now, and presses on what it has met meanwhile. Told once.
    bool has_met_something();
    std::expected<void, Error> check_duty(const Command& command) const;
    bool can_walk(const Command& command) const;
    void absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at);
    /// Whether it may have lost what it was told in that time.
    bool is_doubtful(Duration silence) const { return silence > usual_silence(); }
    Duration usual_silence() const;
    bool is_silent() const;
    bool is_plausible(const actuator::Measured<double>& before);
    /// Whether it counts from where it stood at power-on, and does not say when that was (Nuri).
    bool counts_from_power_on() const { return family().name == "nuri"; }
    bool is_no_leap(const actuator::Measured<double>& before);
    /// Whether it has told where it is since it was silent for so long that it may have started afresh.
    bool is_back() const { return silence_ && raw_.position_rad && raw_.position_rad.at() > silence_->since; }
    /// One exchange. `since`: when it gives no answer, if this is the first failure in a row; `asked`: what went out;
    /// nullptr: nothing did.
    void failed(const Error& error, TimePoint since, const wire::Request* asked);
    void note_missing(const Error& error, TimePoint since);
    void tell(Errc code, std::string says);
    Mode policy() const;
    /// To hold, or to brake where that would be a leap. `unseen` as above.
    Mode holding(bool unseen) const;
    /// How old a place may be where it is told to hold.
    enum class Places : std::uint8_t {
        none,   ///< it may be anywhere
        fresh,  ///< and what turns must not turn back far
        latest, ///< as old as they become on its line while it is looked at all the time
    };
    bool is_to_stay() const;
    /// The maximum where it need not be told where.
    TimePoint seen_until(Places places) const;
    bool is_unseen(Places places, TimePoint at) const { return at > seen_until(places); }
    /// Whether it must be told where to hold, and where it is was not measured lately.
    bool is_unplaced(TimePoint at) const { return is_unseen(Places::latest, at); }
    /// Whether it holds at `held_`, for all that is known.
    bool holds_there() const;
    /// Where a stop tells it to hold: where it does already, for at each new place it gives way to its load once more.
    const State& place_to_hold() const { return holds_there() ? held_ : raw_; }
    /// Whether a stop has told it to hold, and it seems to: then it is not to be braked because nobody looked since.
    bool was_told_to_hold() const { return is_told_ && told_ == Mode::hold && holds_there(); }
    /// In a stop. `place` counts where it is told to hold.
    void begin_telling(Mode mode, const State& place, TimePoint at);
    /// What a stop tells it: the policy, as far as it can.
    Mode stopping(bool unseen) const;
    /// Whether any answer can tell that it does what a stop has told it.
    bool can_confirm(Mode told) const { return told != Mode::release || acknowledges_ || can_.measures_enabled; }
    /// Whether it was told to hold, and its last word of that is that it is off.
    bool is_limp(Mode told) const { return told == Mode::hold && raw_.says_off(); }

    const ResolvedJoint* resolved_;
    const link::Clock* clock_;
    Incidents* incidents_;
    Mounting mounting_;
    std::unique_ptr<actuator::Driver> driver_;
    /// Plans what stops the joint, beforehand: a driver believes that what it planned was sent.
    std::unique_ptr<actuator::Driver> stopper_;
    actuator::Capabilities can_;
    Supervisor guard_;
    Stillness stillness_;
    Mode policy_ = Mode::hold;
    Mode unseen_hold_ = Mode::hold; ///< where it must not be told a place
    bool holds_a_position_ = false; ///< to hold, the device must be told where
    bool acknowledges_ = true;      ///< its answer to a command is worth the repetition
    bool is_absolute_ = false;      ///< its zero is that of the file, and it knows its angle after power-on
    bool referenced_ = false;
    const char* closed_ = "the robot is not enabled yet"; ///< why it takes no command; nullptr: it does
    std::optional<Error> closed_by_;                      ///< a fault of this joint alone

    Command command_{.mode = Mode::hold};
    TimePoint commanded_at_{};
    TimePoint deadline_{};             ///< of a move with a duration
    double mean_velocity_rad_s_ = 0.0; ///< of that move
    struct Walk {
        double to_rad = 0.0, velocity_rad_s = 0.0;
        TimePoint at{};
    };
    std::optional<Walk> walk_;
    State held_{};           ///< where it holds
    bool is_held_ = false;   ///< it was told that last
    Command planned_{};      ///< what went out last, in the units of the actuator
    TimePoint planned_at_{}; ///< when
    bool fresh_ = false;     ///< the command was not sent yet, or its sending failed
    bool has_heard_ = false;
    int repetitions_ = 0; ///< still to be sent, where nobody acknowledges
    // To hold with loops that start anew (`pressing.hpp`).
    bool must_relieve_ = false;
    wire::Requests relief_; ///< what this cycle sent for that
    int retries_ = 0;       ///< so often it is still told that once more where a frame of it was not acknowledged
    /// Nor was the last of these; or it was told by another program what it does.
    bool may_press_on_ = false;
    struct Slowing {
        actuator::Measured<double> current_a;
    };
    std::optional<Slowing> slowing_; ///< as it was when it was told to hold while it turned; until it stands
    // In a stop.
    bool is_told_ = false; ///< what it was told since the stop began
    TimePoint told_at_{};
    Mode told_ = Mode::hold;
    Mode ready_ = Mode::hold; ///< what the frames that are ready tell it
    State ready_place_{};     ///< and where
    int lettings_go_ = 0;     ///< of what it may press on, while it owes its stop
    bool owes_stop_ = false;
    bool unheard_ = false;          ///< a frame of what it was told last was not acknowledged
    bool has_let_go_of_it_ = false; ///< what it was told last began with letting go of what it may press on
    int silences_ = 0;              ///< looks in a row that it did not answer
    Duration silent_for_{};         ///< what those took
    bool is_heard_again_ = false;   ///< it answered the last look, and not the one before
    bool is_given_up_ = false;

    bool begins_anew_ = false; ///< where it is had not been looked at for a while

    State raw_{}, state_{};
    TimePoint answered_at_{};
    actuator::Measured<double> suspect_;     ///< a position that nobody believes yet
    int agreed_ = 0;                         ///< how many answers in a row say that
    Duration interval_{};                    ///< at which it is looked at
    Duration answering_{};                   ///< what that took, the last time
    Duration exchange_{};                    ///< the same of all of its line, or of the line that all wait for
    std::optional<TimePoint> missing_since_; ///< no exchange of its has succeeded since
    std::optional<TimePoint> cut_since_;     ///< all of them were ended by stops since
    struct Silence {
        TimePoint since{};
        Duration lasted{};
    };
    std::optional<Silence> silence_; ///< so long that it may have started afresh, and where it is is not known yet
    bool leapt_ = false;             ///< and nobody has seen to it
    TimePoint full_at_{};            ///< the next full reading is due
    TimePoint check_at_{};           ///< the next look for a reset is due
    bool must_set_up_ = false;
    std::uint64_t failures_ = 0, overruled_ = 0;
    std::optional<Error> trouble_, overruled_by_;
};

} // namespace sinew::robot
