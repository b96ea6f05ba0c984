#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <unistd.h>

// restless ROBOT BUS=LINK…: moves every joint to and fro until it is killed, and says in lines what it is about to do.
// Who turns without end does so: a motor that nobody stops goes on. No two joints turn round at the same moment.
using namespace sinew;
using namespace std::chrono_literals;

namespace {

void move(robot::Robot& robot, Duration since)
{
    constexpr double apart = 0.7;
    double angle = 6.0 * seconds(since);
    for (auto& joint : robot.joints()) {
        const double phase = std::sin(angle += apart);
        const bool turns = joint.capabilities().velocity && joint.family().name != "sam";
        const auto command = turns ? robot::Command{.mode = robot::Mode::velocity, .velocity_rad_s = 0.4 * phase}
                                   : robot::Command{.mode = robot::Mode::position,
                                                    .position_rad = 0.2 * phase + 0.3,
                                                    .velocity_rad_s = 0.8};
        static_cast<void>(joint.set(command)); // at a limit it is refused, and the next one is not
    }
}

void say(const char* word, int number)
{
    std::printf("%s %d\n", word, number);
    std::fflush(stdout);
}

int give_up(const Error& error)
{
    std::fprintf(stderr, "restless: %s\n", to_sentence(error).c_str());
    return 1;
}

} // namespace

int main(int argc, char** argv)
{
    auto guardian = robot::Guardian::start({.patience = 1s});
    if (!guardian)
        return give_up(guardian.error());
    say("guarded", guardian->process_id());
    robot::OpenOptions options{.guardian = &*guardian};
    // A machine with other work keeps answers waiting; that is not what is looked at.
    options.settings.margin_at_first = options.settings.margin_most = 1s;
    options.settings.margin_least = 200ms;
    for (int i = 2; i < argc; ++i)
        if (const char* equals = std::strchr(argv[i], '='))
            options.links.insert_or_assign(std::string(argv[i], static_cast<std::size_t>(equals - argv[i])),
                                           equals + 1);
    link::RealClock clock;
    auto robot = robot::Robot::open(argv[1], link::Links::system(), clock, options);
    if (!robot)
        return give_up(robot.error());
    if (auto on = robot->enable(); !on)
        return give_up(on.error());
    const auto begin = clock.now();
    bool told = false;
    const auto ended = robot->run(10ms, [&](robot::Robot& all) {
        move(all, clock.now() - begin);
        if (!told && clock.now() - begin > 100ms) {
            told = true;
            say("moving", guardian->process_id());
        }
    });
    std::printf("stopped: %s\n", ended ? "?" : to_sentence(ended.error()).c_str());
    std::fflush(stdout);
    for (;;)
        ::pause(); // whoever killed the guardian looks at the motors first
}
