#pragma once
#include "apps/cli/joint.hpp"

/// A move to a position that is watched until it has arrived: the common part of `move` and `home`.
namespace sinew::cli {

struct Goal {
    double position_rad = 0.0; ///< of the joint
    std::optional<double> speed_rad_s;
    std::optional<Duration> duration;
    Duration limit = std::chrono::seconds(60); ///< gives up after this time
    /// Where the device knows no speed for a move: it is led there in small steps.
    bool in_steps = false;
};

/// Sends it there and shows it until it has arrived, stands still or the time is over. Ctrl-C makes it hold.
Outcome move_to(const Words& words, Session& session, Driven& driven, const Goal& goal);

/// What a joint is doing, as a line: `time` since the start.
void show_state(const Words& words, const Driven& driven, Duration since_start);

/// The position of the joint that was read last.
double position_of(const Driven& driven);

/// What a device that does not hold is told: nothing more, or to let go, for what turns without end.
enum class Otherwise { nothing, release };

/// Holds with torque, again where the device does not confirm. No further signal cuts it short.
std::expected<void, Error> come_to_rest(Driven& driven, Otherwise otherwise = Otherwise::nothing);

/// Takes the torque off, again where the device does not confirm. No further signal cuts it short.
std::expected<void, Error> let_go(Driven& driven);

/// Holds because of an error, which then says so where that was not confirmed.
std::unexpected<Error> held_after(Driven& driven, Error why, Otherwise otherwise = Otherwise::nothing);

/// Looks until what was told to hold stands still, and tells it again meanwhile: a command that nobody acknowledges may
/// have been lost. False: it was not seen to, or another Ctrl-C came.
bool stands_still(Session& session, Driven& driven, Otherwise otherwise = Otherwise::nothing);

/// Holds after Ctrl-C and says where it stands. Another Ctrl-C only ends the waiting for it to stand still.
Outcome stop_here(Session& session, Driven& driven, Otherwise otherwise = Otherwise::nothing);

/// Opens, sets up and reads a device that is to move; a guardian holds it when this program dies.
std::expected<Driven, Error> drive_and_read(Session& session, Device device);

} // namespace sinew::cli
