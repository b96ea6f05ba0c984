#include "sinew/robot/play.hpp"

#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/interrupt.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/robot_record.hpp"
#include "apps/cli/robot_session.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/pose.hpp"

#include <charconv>
#include <fmt/format.h>
#include <set>

namespace sinew::cli {
namespace {

using config::Step;
using Status = robot::SequencePlayer::Status;

/// 0.5 or 50%.
std::expected<double, Error> speed_share(const Words& words)
{
    const auto word = words.text("--speed");
    if (!word)
        return 1.0;
    double value = 0.0;
    const auto [end, problem] = std::from_chars(word->data(), word->data() + word->size(), value);
    const std::string_view rest(end, static_cast<std::size_t>(word->data() + word->size() - end));
    const double share = rest == "%" ? value / 100.0 : value;
    if (problem != std::errc{} || (!rest.empty() && rest != "%") || !(share > 0.0 && share <= 1.0))
        return fail(Errc::bad_argument,
                    fmt::format("--speed takes a share of the fastest, such as 0.5 or 50%, not '{}'", *word));
    return share;
}

std::expected<config::Sequence, Error> sequence_from(const Words& words, const config::RobotFile& file)
{
    const std::string name = words.text("NAME").value_or("");
    const auto duration = words.duration("--in");
    if (!duration)
        return std::unexpected(duration.error());
    if (const config::Pose* pose = file.find_pose(name))
        return robot::sequence_of(*pose, {.duration_s = *duration ? std::optional(seconds(**duration)) : std::nullopt});
    if (const config::Sequence* sequence = file.find_sequence(name)) {
        if (*duration)
            return fail(Errc::bad_argument,
                        fmt::format("--in goes with a pose; {} is a sequence, whose steps say it", name));
        return *sequence;
    }
    std::vector<std::string_view> names;
    for (const auto& pose : file.poses)
        names.emplace_back(pose.name);
    for (const auto& sequence : file.sequences)
        names.emplace_back(sequence.name);
    if (names.empty())
        return fail(Errc::unknown_name, fmt::format("{} has no poses and no sequences: write [pose.NAME] or "
                                                    "[sequence.NAME] into it, or teach one with `sinew teach`",
                                                    file.path));
    return fail(Errc::unknown_name,
                fmt::format("{} has no pose or sequence '{}'{}", file.path, name, suggestion(name, names)));
}

void collect(const config::RobotFile& file, const std::vector<Step>& steps, std::set<std::size_t>& joints)
{
    for (const Step& step : steps) {
        for (const config::JointTarget& target : step.targets)
            joints.insert(target.joint);
        collect(file, step.steps, joints);
        if (step.kind == Step::Kind::call)
            collect(file, file.sequences[step.sequence].steps, joints);
    }
}

std::string describe(const config::RobotFile& file, const Step& step)
{
    std::string out;
    if (step.kind == Step::Kind::wait)
        out = fmt::format("wait {:g} s", step.duration_s.value_or(0.0));
    else if (!step.name.value.empty())
        out = fmt::format("pose {}", step.name.value);
    else if (step.kind == Step::Kind::move)
        out = "move";
    for (const config::JointTarget& target : step.targets)
        if (step.name.value.empty())
            out += fmt::format("{} {} {:g} deg", &target == step.targets.data() ? "" : ",",
                               file.joints[target.joint].name, units::deg(target.position_rad));
    if (step.until)
        out += fmt::format("{}until {}", out.empty() ? "" : " ", robot::to_words(file, *step.until, "is"));
    return out;
}

/// What is shown while it plays, and Ctrl-C.
class Reporter
{
public:
    Reporter(const Words& words, robot::Robot& robot) : words_(words), robot_(robot), begin_(robot.clock().now()) {}

    void show(const robot::SequencePlayer& player)
    {
        delayed_ = player.delayed();
        const Step* step = player.step();
        if (step == nullptr || player.steps_begun() == shown_)
            return;
        shown_ = player.steps_begun();
        const auto text = describe(robot_.file(), *step);
        if (words_.json()) {
            print_line(Json::object({{"time_s", time_s()}, {"line", step->at.line}, {"step", text}}));
            return;
        }
        fmt::print("{:8.2f} s  {}\n", time_s(), text);
        std::fflush(stdout);
    }

    /// A motion that was not as quick as planned.
    void tell_delay() const
    {
        constexpr Duration unnoticed = std::chrono::milliseconds(100);
        if (delayed_ > unnoticed)
            fmt::print(stderr,
                       "sinew: it took {:.2f} s longer than planned; a joint was held up, or this machine, a bus or "
                       "step_max_deg is too slow\n",
                       seconds(delayed_));
    }

    /// The first Ctrl-C slows down, the second one stops the robot.
    bool stop_asked()
    {
        if (interrupted()) {
            clear_interrupt();
            if (asked_)
                robot_.request_stop();
            asked_twice_ = asked_;
            asked_ = true;
        }
        return asked_;
    }
    bool stop_asked_twice() const { return asked_twice_; }

    void show_end(std::string_view status)
    {
        if (!words_.json()) {
            fmt::print("{:8.2f} s  {}\n", time_s(), status);
            return;
        }
        Json joints = Json::array();
        for (const robot::Joint& joint : robot_.joints())
            joints.add(Json::object({{"name", joint.name()}, {"position_rad", joint.state().position_rad.optional()}}));
        print_line(Json::object({{"time_s", time_s()}, {"status", status}, {"joints", joints}}));
    }

private:
    double time_s() const { return seconds(robot_.clock().now() - begin_); }

    const Words& words_;
    robot::Robot& robot_;
    TimePoint begin_;
    std::uint64_t shown_ = 0;
    Duration delayed_{};
    bool asked_ = false, asked_twice_ = false;
};

std::expected<bool, Error> may_move(const Words& words, const config::RobotFile& file, const config::Sequence& sequence)
{
    if (words.has("--sim"))
        return true;
    std::set<std::size_t> joints;
    collect(file, sequence.steps, joints);
    return confirm(words, fmt::format("{} of {} will move {} joint{}", sequence.name, file.path, joints.size(),
                                      joints.size() == 1 ? "" : "s"));
}

/// Until its end, its failure or its stop, which are told.
Outcome play_and_tell(const Words& words, RobotSession& session, const config::Sequence& sequence, double speed,
                      RobotRecord* record)
{
    robot::Robot& robot = session.robot();
    if (auto on = robot.enable(); !on)
        return std::unexpected(on.error());
    Reporter reporter(words, robot);
    robot::PlayOptions options{.speed = speed};
    options.each = [&](const robot::SequencePlayer& player) {
        session.tell_incidents();
        reporter.show(player);
        if (record != nullptr)
            record->look();
    };
    options.stop_asked = [&] { return reporter.stop_asked(); };
    auto played = robot::play(robot, sequence, options);
    (void)reporter.stop_asked();
    if (played && reporter.stop_asked_twice()) // too late for its turns to hear it
        if (auto turn = robot.cycle(); !turn)
            played = std::unexpected(std::move(turn.error()));
    std::optional<Error> why;
    if (!played) {
        why = played.error();
        why->id = -1; // its sentence has the name of the joint
    }
    const bool is_told = why && session.has_told(*why);
    session.tell_incidents(played ? nullptr : &played.error());
    if (played)
        reporter.tell_delay();
    if (was_suspension())
        tell_of_suspension();
    // What cannot be played is refused before anything moves; after that the robot itself has stopped a joint.
    if (why && why->code == Errc::out_of_range && robot.fault() != nullptr) {
        if (!is_told)
            fmt::print(stderr, "sinew: {}\n", to_sentence(*why));
        return exit_at_limit;
    }
    if (why)
        return is_told ? Outcome(exit_code(why->code)) : std::unexpected(std::move(*why));
    reporter.show_end(*played == Status::done ? "done" : "stopped; the joints hold");
    return *played == Status::done ? exit_done : exit_interrupted;
}

Outcome run(const Words& words)
{
    auto file = robot_file(words);
    if (!file)
        return std::unexpected(file.error());
    const auto sequence = sequence_from(words, *file);
    if (!sequence)
        return std::unexpected(sequence.error());
    const auto speed = speed_share(words);
    if (!speed)
        return std::unexpected(speed.error());
    const auto yes = may_move(words, *file, *sequence);
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    const auto record = RobotRecord::make(words);
    if (!record)
        return std::unexpected(record.error());
    auto session = RobotSession::open(words, std::move(*file));
    if (!session)
        return std::unexpected(session.error());
    if (*record)
        (*record)->watch((*session)->robot(), words.has("--sim"));
    return recorded(play_and_tell(words, **session, *sequence, *speed, record->get()), record->get());
}

} // namespace

Verb play_verb()
{
    return {.name = "play",
            .says = "Move a robot into a pose, or play a sequence of its file.",
            .arguments = {{"NAME", "a pose or a sequence of the robot file"}},
            .options = with_robot_options({{"--speed", "SHARE", "of the fastest, such as 0.5 or 50%"},
                                           {"--in", "TIME", "be in the pose after this time, such as 3s"},
                                           record_option}),
            .examples = {{"sinew play wave --robot robots/demo.toml --sim", "in the simulator, at once"},
                         {"sinew play greet --in 3s --robot arm.toml", "asks first"},
                         {"sinew play wave --robot arm.toml --speed 50% --yes", "does not ask"},
                         {"sinew play wave --robot robots/demo.toml --sim --record wave.mcap",
                          "for sinew plot and sinew export"}},
            .run = run,
            .more =
                "All joints of a move arrive together, within the limits of the robot file; docs/guide/sequences.md "
                "has the form. At the end the joints hold. Ctrl-C slows down and holds; a second one stops the "
                "robot as [safety] says.",
            .ends = {exit_at_limit}};
}

} // namespace sinew::cli
