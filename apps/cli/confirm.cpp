#include "apps/cli/confirm.hpp"

#include "apps/cli/terminal.hpp"

#include <fmt/format.h>
#include <iostream>

namespace sinew::cli {

std::expected<bool, Error> confirm(const Words& words, std::string_view what)
{
    if (words.has("--yes"))
        return true;
    if (!stdin_is_terminal() || !stderr_is_terminal())
        return fail(Errc::bad_argument, fmt::format("{}: say --yes, for there is no terminal to ask on", what));
    fmt::print(stderr, "{}. Go on? [y/N] ", what);
    std::string answer;
    std::getline(std::cin, answer);
    if (answer == "y" || answer == "Y" || answer == "yes")
        return true;
    fmt::print(stderr, "Nothing was sent.\n");
    return false;
}

} // namespace sinew::cli
