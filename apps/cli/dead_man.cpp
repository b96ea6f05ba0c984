#include "apps/cli/dead_man.hpp"

namespace sinew::cli {

void DeadMan::turn(int direction, TimePoint now)
{
    const bool repeated = direction == direction_ && now - pressed_ < repeats_within && pressed_ != TimePoint{};
    until_ = now + (repeated ? hold : nudge);
    direction_ = direction;
    pressed_ = now;
}

DeadMan::Wish DeadMan::press(std::string_view keys, TimePoint now)
{
    Wish wish = Wish::none;
    while (!keys.empty()) {
        const bool arrow = keys.starts_with("\033[") && keys.size() >= 3;
        const char key = arrow ? keys[2] : keys[0];
        if ((arrow && (key == 'C' || key == 'A')) || (!arrow && (key == 'l' || key == 'k')))
            turn(1, now);
        else if ((arrow && (key == 'D' || key == 'B')) || (!arrow && (key == 'h' || key == 'j')))
            turn(-1, now);
        else if (!arrow && (key == 'q' || key == '\033' || key == '\004'))
            wish = Wish::quit;
        else if (!arrow && key == '+')
            wish = Wish::faster;
        else if (!arrow && key == '-')
            wish = Wish::slower;
        else {
            // Space, and every key that means nothing: whoever hits one wants it to stop.
            until_ = {};
            direction_ = 0;
            pressed_ = {};
            wish = wish == Wish::quit ? wish : Wish::stop;
        }
        keys.remove_prefix(arrow ? 3 : 1);
    }
    return wish;
}

} // namespace sinew::cli
