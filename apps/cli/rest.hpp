#pragma once
#include "apps/cli/joint.hpp"
#include "sinew/robot/stillness.hpp"

#include <functional>
#include <string_view>

/// How one device that moves comes to rest, looked at and not only told: for `move`, `home`, `tune` and `jog`. `stop`
/// tells many before it looks (stopping.hpp), and `play` and `teach` have their robot do it (sinew/robot/stop.cpp).
namespace sinew::cli {

/// What a device that does not take a hold is told: nothing more, or to let go, for what turns without end.
enum class Otherwise { nothing, release };

/// What a device does where it stands.
enum class Rest {
    holds,
    braked, ///< it must be told where to hold, and did not say where it was
    released,
};

/// What it was told: "hold", "brake" or "release".
std::string_view to_verb(Rest rest);

/// What a device was told, and what it said to that.
struct Telling {
    Rest rest = Rest::holds;
    std::expected<void, Error> confirmed;
    /// Where it was told to hold, of what must be told where.
    std::optional<double> place_rad{};
};

inline constexpr Duration between_looks = robot::Stillness::least; ///< at what comes to rest

/// Whether a device stands still, look by look: by its place, in joint units, or where it is too far to say that (Nuri)
/// by two looks in a row that say a speed of 0.
class Standing
{
public:
    explicit Standing(const Driven& driven);

    /// What was read last; nothing where that failed.
    void look(const Driven& driven);
    bool is_at_rest() const { return stillness_.is_at_rest() || slow_looks_ > 1; }

private:
    robot::Stillness stillness_;
    int slow_looks_ = 0;
};

/// Once; nobody looks. Where the protocol can hold without knowing the position nothing is read first; what must be
/// told where to hold, and does not say where it is, is braked. `last`: the place of an earlier telling, told again
/// where it is no further off than it may give way (`robot::giving_way_rad`), for under a load each new place would be
/// lower than the one before; what is further off has not heard it.
Telling tell_to_hold(Driven& driven, std::optional<double> last = {});

/// So often at most something is told to let go; each time lets a load come down a little.
inline constexpr int most_reliefs = 3;
/// What holds lets go of what it presses on and holds anew (`robot::plan_hold_anew`); `told`: that it holds. Where one
/// frame of that was not acknowledged it is told to hold, again and again as ever, and the answer is false: it may not
/// have let go. No signal comes between.
bool hold_anew(Driven& driven, Telling& told);
/// Whether what it is told to hold may press on something.
bool may_press(const Driven& driven);
/// What is said of one that never acknowledged to let go.
inline constexpr std::string_view may_press_on =
    "holds, but never acknowledged that it lets go of what blocks it, so it may press on that; switch its supply off "
    "before you reach for it";

/// Tells it to hold, looks, and tells it again until it is seen at rest: a command that nobody acknowledges may have
/// been lost. No signal cuts the telling short, and one that came before is still there afterwards. `timeout` and the
/// like: it did not confirm, or was not seen to stand still, and the sentence says that it may still turn. `stopped`:
/// it was told, and a Ctrl-C that came meanwhile ended the looking.
std::expected<Rest, Error> come_to_rest(Session& session, Driven& driven, Otherwise otherwise = Otherwise::nothing);

/// Takes the torque off, again where the device does not confirm; nobody looks. Signals are as above.
std::expected<void, Error> let_go(Driven& driven);

/// Comes to rest because of an error, which then also says where it is held, or what is not as it should be: a device
/// that did not confirm, or that took no hold. Signals are as above.
std::unexpected<Error> held_after(Session& session, Driven& driven, const Error& why,
                                  Otherwise otherwise = Otherwise::nothing);

/// Comes to rest after Ctrl-C, which has been seen then, and says how; `before_words` is called when it is at rest, and
/// nothing is written before. Another Ctrl-C only ends the waiting for it to stand still.
Outcome stop_here(Session& session, Driven& driven, Otherwise otherwise = Otherwise::nothing,
                  const std::function<void()>& before_words = {});

/// What a person is told of a device that took no hold; empty where it holds.
std::string says_of(const Driven& driven, Rest rest);

} // namespace sinew::cli
