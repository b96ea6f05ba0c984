#include "sinew/actuator/actuator.hpp"

namespace sinew::actuator {

std::string_view to_word(Mode mode)
{
    switch (mode) {
    case Mode::hold:
        return "hold";
    case Mode::release:
        return "release";
    case Mode::position:
        return "position";
    case Mode::velocity:
        return "velocity";
    }
    return "?";
}

} // namespace sinew::actuator
