#include "sinew/link/echo.hpp"

#include <fmt/format.h>

namespace sinew::link {

std::expected<bool, Error> echo_option(const Uri& uri)
{
    const auto echo = uri.option("echo").value_or("off");
    if (echo != "on" && echo != "off")
        return fail(Errc::bad_uri, fmt::format("option echo must be on or off, not '{}'", echo));
    return echo == "on";
}

} // namespace sinew::link
