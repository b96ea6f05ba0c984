#include "tests/robot/beyond.hpp"
#include "tests/robot/random_robots.hpp"
#include "tests/robot/watch.hpp"
#include "tests/support/random.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <utility>

/// Random programs, good and bad, on two robots, one of them the demo robot, to
/// which random things happen. No command beyond a limit leaves the host, no
/// shaft goes further beyond a limit than it needs to stop, and a stop stops.
/// SINEW_PROGRAMS is how many, SINEW_SEED makes a run again, SINEW_PROGRAM is
/// the number of the only one to run, and shows all that happens in it.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;
using sinew::test::Random;

class Program
{
public:
    Program(const config::RobotFile& file, Random random, bool with_wire_faults, bool shows)
        : random_(random), shows_(shows), wire_faults_(with_wire_faults), rig_(file, {.double_read = with_wire_faults}),
          watch_(rig_)
    {
        // Nobody else looks while the robot runs itself.
        watch_.each_frame = [this] {
            if (runs_itself_)
                look();
        };
        for (const Joint& joint : rig_.robot->joints())
            looks_.push_back({.beyond = Beyond(joint)});
    }

    void run()
    {
        EXPECT_TRUE(rig_.robot->enable().has_value());
        const TimePoint end = rig_.now() + 2s;
        TimePoint last = rig_.now();
        while (rig_.now() < end) {
            wish_some();
            if (random_.one_in(200))
                rig_.robot->request_stop();
            if (random_.one_in(60))
                happen();
            if (random_.one_in(100)) {
                random_.one_in(2) ? go_home() : run_itself();
                last = rig_.now();
            }
            if (random_.one_in(100))
                wait(rig_.now() + Duration{static_cast<std::int64_t>(random_.below(60)) * 1'000'000});
            if (!rig_.robot->enabled() && random_.one_in(4))
                (void)rig_.robot->enable();
            const TimePoint next = rig_.now() + 5ms;
            watch_.cycle_begins();
            const auto done = rig_.robot->cycle();
            if (shows_)
                show(done);
            gap_before_ = std::exchange(gap_, rig_.now() - last);
            last = rig_.now();
            look();
            wait(next);
        }
        mend();
        check_stop();
    }

    const Watch& watch() const { return watch_; }
    std::vector<std::string> complaints;
    int accepted = 0, refused = 0;

private:
    struct Look {
        Beyond beyond;
        double crossed_rad_s = 0.0; ///< when it was last seen within its limits
        Duration unnoticed{};
        bool started_afresh = false, heated = false;
        bool is_let_go = false; ///< by the program, on its way out
        TimePoint measured_at{};
        Duration interval{}, interval_before{}; ///< between the latest positions that were measured
    };

    double between(double low, double high)
    {
        return low + (high - low) * static_cast<double>(random_.below(1'000'001)) / 1e6;
    }
    /// Mostly sensible, sometimes not at all.
    double around(double low, double high)
    {
        constexpr double nonsense[] = {std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::infinity(),
                                       -std::numeric_limits<double>::infinity(),
                                       1e300,
                                       -1e300,
                                       0.0};
        if (random_.one_in(20))
            return nonsense[random_.below(std::size(nonsense))];
        const double width = high - low;
        return random_.one_in(4) ? between(low - width, high + width) : between(low, high);
    }

    /// What is no number of seconds is no duration either.
    static Duration lasting(double seconds)
    {
        return std::abs(seconds) < 1e6 ? Duration{static_cast<std::int64_t>(seconds * 1e9)} : Duration::min();
    }

    Duration random_time(std::int64_t least_ms, std::int64_t most_ms)
    {
        return std::chrono::milliseconds{
            least_ms + static_cast<std::int64_t>(random_.below(static_cast<std::uint64_t>(most_ms - least_ms)))};
    }

    /// Seldom in time, so that what a routine leaves behind is seen as well.
    void go_home()
    {
        const auto& joints = rig_.robot->joints();
        const Duration within = random_time(10, 500);
        watch_.runs_itself();
        runs_itself_ = true;
        const auto homed = random_.one_in(2) ? rig_.robot->home(within)
                                             : rig_.robot->home(joints[random_.below(joints.size())].name(), within);
        runs_itself_ = false;
        if (shows_)
            fmt::print("{:.4f} home: {}\n", seconds(rig_.now().time_since_epoch()), said(homed));
    }

    void run_itself()
    {
        const TimePoint until = rig_.now() + random_time(5, 150);
        watch_.runs_itself();
        runs_itself_ = true;
        const auto ran = rig_.robot->run(
            random_time(2, 20),
            [this](Robot& robot) {
                wish_some();
                if (random_.one_in(60))
                    happen();
                if (random_.one_in(200))
                    robot.request_stop();
            },
            until);
        runs_itself_ = false;
        if (shows_)
            fmt::print("{:.4f} run: {}\n", seconds(rig_.now().time_since_epoch()), said(ran));
    }

    /// As many for each joint, however many there are.
    void wish_some()
    {
        for (auto wishes = random_.below(1 + 2 * rig_.robot->joints().size() / 5); wishes > 0; --wishes)
            wish();
    }

    void wish()
    {
        Joint& joint = rig_.robot->joints()[random_.below(rig_.robot->joints().size())];
        const auto& limits = joint.limits();
        const double speed = *limits.velocity_max_rad_s;
        Command command{.mode = static_cast<Mode>(random_.below(8))};
        const double here = joint.state().position_rad.value_or(0.0);
        if (command.mode == Mode::position || random_.one_in(30))
            command.position_rad = random_.one_in(2) ? here + around(-0.03, 0.03)
                                                     : around(*limits.position_low_rad, *limits.position_high_rad);
        if (command.mode == Mode::velocity || random_.one_in(6))
            command.velocity_rad_s = around(command.mode == Mode::velocity ? -speed : 0.0, speed);
        if (command.mode == Mode::current)
            command.current_a = around(-1.0, 1.0) * limits.current_max_a.value_or(1.0);
        if (command.mode == Mode::torque)
            command.torque_nm = around(-1.0, 1.0);
        if (command.mode == Mode::duty)
            command.duty = around(-0.5, 0.5);
        if (random_.one_in(8))
            command.duration = lasting(around(-0.1, 2.0));
        if (command.mode == Mode::release && !random_.one_in(3))
            command.mode = Mode::hold;
        const auto set = joint.set(command);
        set ? ++accepted : ++refused;
        if (shows_ && set)
            fmt::print("{:.4f} {} is set to {}: {:.3f} deg, {:.3f} deg/s\n", seconds(rig_.now().time_since_epoch()),
                       joint.name(), to_word(command.mode), units::deg(command.position_rad.value_or(0.0)),
                       units::deg(command.velocity_rad_s.value_or(0.0)));
    }

    /// Something goes wrong.
    void happen()
    {
        const auto joints = rig_.robot->joints();
        const auto buses = rig_.robot->buses();
        const std::size_t index = random_.below(joints.size());
        const std::string joint = joints[index].name();
        if (shows_)
            fmt::print("{:.4f} something happens to {} or a bus\n", seconds(rig_.now().time_since_epoch()), joint);
        if (!wire_faults_) {
            // A Nuri has another zero afterwards, and nobody can tell.
            if (joints[index].family().name != "nuri" && random_.one_in(3)) {
                rig_.simulator->world().find_device(joint)->power_cycle();
                looks_[index].started_afresh = true;
            } else {
                const bool is_hot = !random_.one_in(2);
                rig_.inject(is_hot ? sim::FaultKind::hot_motor : sim::FaultKind::stuck_gear, joint, 0.1);
                looks_[index].heated |= is_hot;
            }
            return;
        }
        sim::Fault fault{.bus = std::string(buses[random_.below(buses.size())]->name()), .for_s = between(0.01, 0.7)};
        switch (random_.below(5)) {
        case 0:
            fault.kind = sim::FaultKind::flip_bits;
            fault.probability = 0.005;
            break;
        case 1:
            fault.kind = sim::FaultKind::drop_bytes;
            fault.probability = 0.05;
            break;
        case 2:
            fault.kind = sim::FaultKind::unplug;
            fault.bus.clear();
            fault.joint = joint;
            break;
        case 3:
            fault.kind = sim::FaultKind::delay_replies;
            fault.probability = 0.1;
            break;
        default:
            unplugged_ = fault.bus;
            rig_.simulator->set_plugged(unplugged_, false);
            wait(rig_.now() + 3ms);
            if (random_.one_in(2))
                rig_.simulator->set_plugged(unplugged_, true);
            return;
        }
        rig_.simulator->world().inject(fault);
    }

    void mend()
    {
        for (const bus::Bus* bus : rig_.robot->buses()) {
            rig_.simulator->set_plugged(bus->name(), true);
            rig_.simulator->world().mend(bus->name());
        }
        for (const Joint& joint : rig_.robot->joints())
            rig_.simulator->world().mend(joint.name());
        wait(rig_.now() + 300ms);
    }

    void wait(TimePoint until)
    {
        while (rig_.now() < until)
            rig_.simulator->clock().wait({}, until);
    }

    /// What a cycle came to.
    void show(const std::expected<void, Error>& done)
    {
        fmt::print("{:.4f} {}", seconds(rig_.now().time_since_epoch()), done ? "" : said(done) + " ");
        for (const Joint& joint : rig_.robot->joints())
            fmt::print("| {} {} at {:.2f}, is at {:.2f} deg, {:.1f} deg/s ", joint.name(),
                       to_word(joint.command().mode), units::deg(joint.state().position_rad.value_or(0.0)),
                       units::deg(rig_.truth_rad(joint)), units::deg(rig_.truth_rad_s(joint.name())));
        fmt::print("\n");
        for (; shown_ < rig_.robot->incidents().size(); ++shown_)
            fmt::print("       incident: {}\n", rig_.robot->incidents()[shown_].says);
    }

    void look()
    {
        const auto joints = rig_.robot->joints();
        for (std::size_t i = 0; i < joints.size(); ++i)
            look(joints[i], looks_[i]);
    }

    void look(const Joint& joint, Look& look)
    {
        const double at = rig_.truth_rad(joint);
        const double low = *joint.limits().position_low_rad - at, high = at - *joint.limits().position_high_rad;
        const double beyond = std::max(low, high);
        check_belief(joint, look, at);
        // What was planned before this cycle went out in it; what it showed counts
        // in the next one.
        if (const auto& said = joint.state().position_rad; said && said.at() != look.measured_at) {
            look.interval_before = std::exchange(look.interval, said.at() - look.measured_at);
            look.measured_at = said.at();
        }
        const Duration cycle = runs_itself_ ? look.interval : gap_;
        const Duration cycles = runs_itself_ ? look.interval_before + look.interval : gap_before_ + gap_;
        const Duration unnoticed = joint.silent_for() + cycles + 5ms + blind(joint, look, cycle);
        const bool is_let_go = joint.command().mode == Mode::release;
        look.is_let_go = is_let_go || (beyond > 0.0 && look.is_let_go);
        if (beyond <= 0.0) {
            look.crossed_rad_s = rig_.truth_rad_s(joint.name());
            look.unnoticed = unnoticed;
            return;
        }
        look.unnoticed = std::max(look.unnoticed, unnoticed);
        const double most = look.beyond.most_rad(look.crossed_rad_s, look.unnoticed, look.is_let_go);
        if (beyond > most)
            complaints.push_back(fmt::format("{} is {:.2f} deg beyond its limit, {:.2f} deg would be possible",
                                             joint.name(), units::deg(beyond), units::deg(most)));
    }

    /// What answers without a checksum is believed by how fast a shaft can turn (`Joint::is_plausible`), so it is no
    /// further off than a shaft may jump, may turn between two answers, and has turned since.
    void check_belief(const Joint& joint, const Look& look, double truth_rad)
    {
        const auto& said = joint.state().position_rad;
        if (!joint.family().protocol->bare_replies() || !said || !rig_.robot->enabled())
            return;
        const double top_rad_s = *joint.capabilities().velocity_max_rad_s;
        const Duration between = said.at() != look.measured_at ? said.at() - look.measured_at : look.interval;
        const double most = units::rad(2.0) + 1.5 * top_rad_s * std::max(0.02, seconds(between)) +
                            top_rad_s * seconds(rig_.now() - said.at());
        const double off = std::abs(std::remainder(*said - truth_rad, 2.0 * std::numbers::pi));
        if (off > most)
            complaints.push_back(
                fmt::format("{} is believed to be {:.2f} deg from where it is, {:.2f} deg would be possible",
                            joint.name(), units::deg(off), units::deg(most)));
    }

    /// How long a device goes its own way though it answers.
    static Duration blind(const Joint& joint, const Look& look, Duration cycle)
    {
        Duration out{};
        // Nobody reaches a device while it starts.
        if (look.started_afresh)
            out += 200ms;
        // A SAM that is too hot coasts from then on, and says so only when it is
        // read wholly: every 0.5 s, and then in turn with the others of its bus,
        // each in a cycle of its own.
        if (look.heated && joint.family().name == "sam")
            out += 500ms + 6 * (cycle + 5ms);
        return out;
    }

    void check_stop()
    {
        (void)rig_.robot->enable();
        for (Joint& joint : rig_.robot->joints())
            (void)joint.set({.mode = Mode::velocity, .velocity_rad_s = 0.3});
        (void)rig_.robot->cycle();
        wait(rig_.now() + 20ms);
        for (const auto& one : rig_.robot->stop()) {
            if (one.outcome == Stopped::Outcome::failed)
                complaints.push_back(fmt::format("{} was not stopped: {}", one.joint, to_sentence(one.why)));
            // What its program let go of coasts, where the robot could not be enabled again.
            if (one.did != Mode::release && std::abs(rig_.truth_rad_s(one.joint)) > 0.05)
                complaints.push_back(fmt::format("{} turns at {:.2f} rad/s after the stop to {}, {}", one.joint,
                                                 rig_.truth_rad_s(one.joint), actuator::to_word(one.did),
                                                 to_word(one.outcome)));
        }
    }

    Random random_;
    bool shows_;
    std::size_t shown_ = 0;
    bool wire_faults_;
    bool runs_itself_ = false; ///< the robot
    Rig rig_;
    Watch watch_;
    std::string unplugged_;
    Duration gap_{}, gap_before_{}; ///< between the ends of the latest cycles
    std::vector<Look> looks_;       ///< by joint
};

TEST(Program, NothingBeyondALimitLeavesTheHostAndNoShaftGoesFurtherThanItNeedsToStop)
{
    const auto programs = sinew::test::setting("SINEW_PROGRAMS", 500);
    const auto only = sinew::test::setting("SINEW_PROGRAM", ~std::uint64_t{0});
    const bool is_one = only != ~std::uint64_t{0};
    const auto small = file_of(robot_text), large = file_of(demo_text());
    std::size_t motions = 0;
    int accepted = 0, refused = 0, failures = 0;
    for (std::uint64_t i = is_one ? only : 0; i < (is_one ? only + 1 : programs) && failures < 10; ++i) {
        Program program(i / 2 % 2 == 0 ? large : small, Random(fmt::format("robot program {}", i)), i % 2 == 1, is_one);
        program.run();
        motions += program.watch().motions();
        accepted += program.accepted;
        refused += program.refused;
        for (const auto* all : {&program.watch().complaints(), &std::as_const(program.complaints)})
            if (!all->empty()) {
                ADD_FAILURE() << "SINEW_SEED=" << sinew::test::seed() << " SINEW_PROGRAM=" << i << ": " << all->front()
                              << " (and " << all->size() - 1 << " more)";
                ++failures;
            }
    }
    fmt::print("{} programs, {} commands taken, {} refused, {} motion frames; "
               "SINEW_SEED={}\n",
               programs, accepted, refused, motions, sinew::test::seed());
    EXPECT_GT(motions, is_one ? 0 : programs * 100);
    EXPECT_GT(refused, 0);
}

} // namespace
} // namespace sinew::robot::test
