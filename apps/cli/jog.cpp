#include "apps/cli/confirm.hpp"
#include "apps/cli/dead_man.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/jog_aim.hpp"
#include "apps/cli/moving.hpp"
#include "apps/cli/raw_terminal.hpp"
#include "apps/cli/supervised.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/units.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration tick = std::chrono::milliseconds(20);
constexpr int ticks_per_look = 4;
constexpr double default_speed_rad_s = units::rad(15.0);
constexpr double least_speed_rad_s = units::rad(0.5);

/// A joint that follows the keys by small steps of its target.
class Jog
{
public:
    Jog(const Words& words, Session& session, Driven& driven, double speed_rad_s)
        : words_(words), session_(session), driven_(driven), speed_(speed_rad_s), begin_(session.clock().now()),
          supervised_(session, driven), aim_(driven.device.joint)
    {
    }

    Outcome run()
    {
        fmt::print(stderr, "Hold an arrow key (or h and l) to turn; space stops, + and - change the speed, q ends.\n");
        TimePoint next = session_.clock().now();
        for (int n = 0;; ++n, next = std::max(next + tick, session_.clock().now())) {
            wait_until(session_, next);
            const auto keys = terminal_.keys();
            const auto wish = keys ? man_.press(*keys, session_.clock().now()) : DeadMan::Wish::quit;
            if (interrupted() || wish == DeadMan::Wish::quit)
                return end();
            change_speed(wish);
            auto done = turn(man_.direction(session_.clock().now()), n % ticks_per_look == 0);
            if (interrupted())
                return end();
            if (!done)
                return end(done.error());
            if (wants_to_end_)
                return end();
        }
    }

private:
    Outcome end()
    {
        const bool by_interrupt = interrupted();
        const auto stopped = stop_here(session_, driven_, Otherwise::nothing, [this] { end_line(); });
        direction_ = 0;
        if (stopped && words_.json())
            show();
        return stopped && !by_interrupt ? Outcome(exit_done) : stopped;
    }

    /// What was brought to rest in vain is not told once more, nor what was never told to turn.
    Outcome end(const Error& why)
    {
        const auto ends_line = [this] { end_line(); };
        if (!is_told_ && supervised_.has_sent())
            return stopped_for(session_, driven_, why, Otherwise::nothing, ends_line);
        end_line();
        return std::unexpected(why);
    }

    void end_line() const
    {
        if (!words_.json())
            fmt::print("\n");
    }

    void change_speed(DeadMan::Wish wish)
    {
        if (wish == DeadMan::Wish::faster)
            speed_ = aim_.faster_rad_s(speed_);
        if (wish == DeadMan::Wish::slower)
            speed_ = std::max(speed_ / JogAim::speed_factor, least_speed_rad_s);
    }

    std::expected<void, Error> turn(int direction, bool looks)
    {
        if (looks || supervised_.is_missing())
            if (auto fine = supervised_.look(); !fine)
                return fine;
        const auto here = position_of(driven_);
        if (direction != 0 && !here)
            return {}; // and not from where it may be
        if (direction_ == 0)
            aim_.forget();
        std::optional<double> target;
        if (direction != 0)
            target = aim_.step(*here, direction, speed_ * seconds(tick), units::rad(5.0) + 0.3 * speed_);
        if (!target)
            direction = 0;
        std::expected<void, Error> done;
        if (target) {
            done = go(*target);
        } else if (direction_ != 0) {
            if (const auto rest = come_to_rest(session_, driven_); !rest) {
                is_told_ = true;
                done = std::unexpected(rest.error());
            }
            supervised_.rests();
            forget_keys();
        }
        direction_ = direction;
        if (looks)
            show();
        return done;
    }

    /// Those that were pressed while it was brought to rest: whoever let go of them since must not set it in motion.
    void forget_keys()
    {
        const auto keys = terminal_.keys();
        DeadMan unheeded;
        wants_to_end_ = !keys || unheeded.press(*keys, session_.clock().now()) == DeadMan::Wish::quit;
    }

    std::expected<void, Error> go(double target_rad)
    {
        actuator::Command command{.mode = actuator::Mode::position,
                                  .position_rad = supervised_.nearest_step_rad(target_rad)};
        // A little faster than the steps, so that it is there when the next one comes.
        if (driven_.driver->capabilities().velocity_limit)
            command.velocity_rad_s = aim_.faster_rad_s(speed_);
        return supervised_.send(command);
    }

    void show() const
    {
        if (words_.json()) {
            Json line = state_json(driven_, session_.clock().now() - begin_);
            line.set("direction", direction_);
            line.set("speed_rad_s", speed_);
            print_line(line);
            return;
        }
        const char* mark = direction_ > 0 ? ">>" : direction_ < 0 ? "<<" : "--";
        const auto line = fmt::format("{}  {:>13}  {}  {:.3g} deg/s", driven_.device.name, place_of(driven_), mark,
                                      units::deg(speed_));
        fmt::print("\r{}\033[K", line.substr(0, columns() - 1));
        std::fflush(stdout);
    }

    const Words& words_;
    Session& session_;
    Driven& driven_;
    double speed_;
    TimePoint begin_;
    Supervised supervised_;
    RawTerminal terminal_;
    DeadMan man_;
    JogAim aim_;
    int direction_ = 0;
    bool is_told_ = false; ///< to hold, with an error for all that came of it
    bool wants_to_end_ = false;
};

/// Keys are pressed in real time, so the simulator must run in it.
void in_real_time(Device& device)
{
    auto uri = link::parse_uri(device.link);
    if (!uri || uri->scheme != "sim" || uri->option("clock"))
        return;
    uri->options.emplace_back("clock", "real");
    device.link = link::to_string(*uri);
}

Outcome run(const Words& words)
{
    double speed_rad_s = default_speed_rad_s;
    if (const auto word = words.text("--speed")) {
        const auto speed = speed_from(*word);
        if (!speed)
            return std::unexpected(speed.error());
        speed_rad_s = *speed;
    }
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    if (device->joint != nullptr && device->joint->velocity_max_rad_s &&
        speed_rad_s > *device->joint->velocity_max_rad_s)
        return fail(Errc::out_of_range,
                    fmt::format("{} may not turn faster than {:g} deg/s (velocity_max_deg_s of {})", device->name,
                                units::deg(*device->joint->velocity_max_rad_s), device->file->path));
    if (!stdin_is_terminal() || (!stdout_is_terminal() && !words.json()))
        return fail(Errc::bad_argument, "jog needs a terminal: it moves while keys are held; sinew move goes to a "
                                        "position without one");
    const auto yes = confirm(words, fmt::format("{} will turn while you hold a key", device->name));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    in_real_time(*device);
    Session session;
    auto driven = drive_and_read(session, std::move(*device));
    if (!driven)
        return std::unexpected(driven.error());
    return Jog(words, session, *driven, speed_rad_s).run();
}

} // namespace

Verb jog_verb()
{
    return {
        .name = "jog",
        .says = "Turn a device by keys, only as long as a key is held.",
        .arguments = {target_argument},
        .options =
            with_device_options({{"--speed", "S", "how fast at first, such as 30deg/s; 15deg/s where it is not given"},
                                 yes_option,
                                 {"--json", "", "print one object per look and line; stdout may then be a pipe"}}),
        .examples = {{"sinew jog elbow --robot arm.toml", "asks first"},
                     {"sinew jog elbow --robot arm.toml --sim --yes", "a simulated one"},
                     {"sinew jog slcan:/dev/ttyACM0 --family rmd --id 1 --speed 5deg/s", "slowly"}},
        .run = run,
        .acts = true,
        .more =
            "Arrow keys or h and l turn, space or any other key stops, + and - change the speed, q ends. One "
            "press is a nudge of a tenth of a second; it goes on while the key repeats and stops within 0.2 s "
            "after the last. The limits of the robot file hold; beyond one only the key that leads back turns. At the "
            "end it holds its position.",
        .ends = {exit_at_limit}};
}

} // namespace sinew::cli
