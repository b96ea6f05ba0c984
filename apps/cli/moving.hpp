#pragma once
#include "apps/cli/rest.hpp"

/// A move to a position that is watched until it has arrived: the common part of `move` and `home`.
namespace sinew::cli {

struct Goal {
    double position_rad = 0.0;         ///< of the joint
    std::optional<double> speed_rad_s; ///< not given: the most that the robot file allows
    std::optional<Duration> duration;
    Duration limit = std::chrono::seconds(60); ///< gives up after this time
};

/// Sends it there, or leads it in small steps where the device knows no speed for a move, and shows it until it has
/// arrived, stands still, comes to a limit or the time is over. Whatever ends it on the way makes it hold: Ctrl-C too.
Outcome move_to(const Words& words, Session& session, Driven& driven, const Goal& goal);

/// What a joint is doing, as a line: `time` since the start.
void show_state(const Words& words, const Driven& driven, Duration since_start);

/// Opens, sets up and reads a device that is to move; a guardian holds it when this program dies. `bad_reply` where it
/// says that it is another one than it should be: nothing has been set then.
std::expected<Driven, Error> drive_and_read(Session& session, Device device);

} // namespace sinew::cli
