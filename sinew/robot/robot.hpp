#pragma once
#include "sinew/bus/bus.hpp"
#include "sinew/link/links.hpp"
#include "sinew/robot/joint.hpp"

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::robot {

class Core;
class Guardian;

struct OpenOptions {
    std::map<std::string, std::string> links; ///< by bus, in place of those of the file
    bool simulated = false;                   ///< every other bus is `sim:FILE#BUS`; the links must know that scheme
    bus::Settings settings{};
    /// Stops the motors when the program dies; started before the links were opened, and it must outlive the robot. A
    /// guardian that was killed stops the robot. `enable` fails where it cannot reach a link; one that is within this
    /// process (a simulator's) ends with it and needs none.
    Guardian* guardian = nullptr;
};

/// What a stop did to one joint.
struct Stopped {
    enum class Outcome : std::uint8_t {
        confirmed, ///< the device said so itself: it rests, or it is off
        sent,      ///< it went out, and no answer can tell
        failed,
    };
    std::string_view joint;
    Mode did = Mode::hold; ///< as the policy of the robot file says and the device can
    Outcome outcome = Outcome::failed;
    Error why{}; ///< of a failure
};

std::string_view to_word(Stopped::Outcome outcome);

/// The joints and buses of one robot file, and the cycle that runs them.
///
///     auto robot = Robot::open("arm.toml", links, clock);
///     robot->enable();
///     robot->set("elbow", {.mode = Mode::position, .position_rad = 1.0, .velocity_rad_s = 0.5});
///     while (...) robot->cycle();
///     robot->stop();
///
/// Nothing happens by itself: whoever calls `cycle` or `run` drives all buses, in his own thread, one thread at a time;
/// only `request_stop` may be called from any thread and from a signal handler. In the steady state a cycle uses no
/// heap and no system call but those of its buses.
///
/// **Real time.** Before its first cycle a thread gets what `[bus.NAME.realtime]` of the file asks for
/// (`bus/real_time.hpp`): the highest priority and the first processor of any bus, for it drives them all. Each refusal
/// is an incident and stops nothing. In virtual time nothing is asked for. Threads that it starts later inherit
/// priority and processor.
///
/// **Safety.** What is beyond a limit is refused and never sent. Every cycle looks at what was measured: at a limit a
/// joint holds; without commands it does what `[safety]` says (`command_timeout_s`); a fault, a joint that falls silent
/// or a lost link stops the robot by the policy of the file, and every later cycle only reads and returns that error
/// until `enable` is called again. Nothing of that is silent: `incidents`. A robot that is destroyed while an exception
/// is on its way is stopped; a normal end leaves its joints as they were asked.
class Robot
{
public:
    /// Opens all buses; sends nothing. The clock must outlive the robot and is that of its links: `sim::clock_for` for
    /// simulated ones. `bad_file` with the place, or why a link does not open.
    static std::expected<Robot, Error> open(const std::filesystem::path& path, const link::Links& links,
                                            link::Clock& clock, const OpenOptions& options = {});
    static std::expected<Robot, Error> open(config::RobotFile file, const link::Links& links, link::Clock& clock,
                                            const OpenOptions& options = {});
    ~Robot();
    Robot(Robot&&) noexcept;
    Robot& operator=(Robot&&) noexcept;

    /// Compares every device with the robot file where it can tell what it is, applies the run-time settings, reads all
    /// states, and makes every joint hold where it is. Nothing moves when something is wrong; then the error says what.
    /// Also the way back after a stop: what a lost link has not heard of that goes out first. One that is enabled holds
    /// at once, and is stopped where something is wrong. Not from within `each` of `run`.
    std::expected<void, Error> enable();
    bool enabled() const;

    /// One turn: sends all commands, on all buses at once, and reads what they bring. Returns when the slowest bus is
    /// done: some hundred milliseconds where a device is silent, and as long nobody looks at the joints of the other
    /// buses. What drives without end (velocity, current, torque, duty) is better run by `run`, where no bus waits. An
    /// error of one exchange shows in `Joint::trouble` and in the age of its state; what is returned here has stopped
    /// the robot.
    std::expected<void, Error> cycle();
    /// Cycles until `until`, or until something stops the robot, with `each` once a `period`. Every bus goes at the
    /// rate of the file (`rate_hz`), else at that of `period`, and waits for no other one.
    std::expected<void, Error> run(Duration period, const std::function<void(Robot&)>& each,
                                   TimePoint until = TimePoint::max());
    /// From within `each`: this turn is the last one of `run`.
    void leave() noexcept;
    /// Cycles for so long, as fast as the slowest bus goes but no faster than every `period`.
    std::expected<void, Error> wait(Duration duration, Duration period = std::chrono::milliseconds{10});
    /// Takes a joint to its position 0, slowly, by `[joint.NAME.home]` of the file: with `routine = "stop"` it first
    /// turns until something stops it, as far as `travel_max_deg` says or its range allows, and takes that for its
    /// reference. An unreferenced joint without such a routine goes to where it counts 0, and an incident says so.
    /// `timeout` where it finds no stop or does not arrive, or what else ended its motion; then whatever still was on
    /// its way was told to hold, and was looked at.
    std::expected<void, Error> home(std::string_view joint, Duration within = std::chrono::seconds{60});
    /// All joints at once.
    std::expected<void, Error> home(Duration within = std::chrono::seconds{60});
    /// A fresh state of all joints at once, without a command to any. The first error, after all were asked.
    std::expected<void, Error> read(Depth depth = Depth::full);

    /// Stops every joint by the policy of the file, goes on past failures, asks what it can whether it worked, and says
    /// again what was not confirmed. Takes as long as that takes; the first frames are out at once.
    std::vector<Stopped> stop();
    /// Has it done by whoever drives, at the next frame boundary.
    void request_stop() noexcept;
    /// Why the robot is stopped; nullptr: it is not.
    const Error* fault() const;

    std::span<Joint> joints(); ///< in the order of the file
    Joint* find(std::string_view joint);
    /// Of a joint by name; `unknown_name` suggests the nearest.
    std::expected<void, Error> set(std::string_view joint, const Command& command);
    std::expected<State, Error> state(std::string_view joint);
    /// What happened that nobody asked for, the oldest first; the last 256.
    std::span<const Incident> incidents() const;
    /// How many before them are no longer there: this and the index of an incident are its number since the beginning.
    std::uint64_t incidents_dropped() const;

    std::span<bus::Bus* const> buses() const; ///< in the order of the file
    /// What a stop of this bus sends, ready-made, as of the last cycle: for a guardian.
    std::span<const wire::Request> stop_requests(std::size_t bus) const;
    /// The same for when nobody has looked at the joints for a while: it tells no joint to hold where it was.
    std::span<const wire::Request> unseen_stop_requests(std::size_t bus) const;
    const config::RobotFile& file() const;
    link::Clock& clock() const;

private:
    explicit Robot(std::unique_ptr<Core> core);

    std::unique_ptr<Core> core_;
};

} // namespace sinew::robot
