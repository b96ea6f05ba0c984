#include "apps/cli/raw_terminal.hpp"

#include <array>
#include <poll.h>
#include <unistd.h>

namespace sinew::cli {

RawTerminal::RawTerminal()
{
    if (::tcgetattr(STDIN_FILENO, &before_) != 0)
        return;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    changed_ = ::tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

RawTerminal::~RawTerminal()
{
    if (changed_)
        ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

std::optional<std::string> RawTerminal::keys()
{
    std::string out;
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    while (::poll(&input, 1, 0) > 0) {
        std::array<char, 256> buffer;
        const auto size = ::read(STDIN_FILENO, buffer.data(), buffer.size());
        if (size <= 0)
            return out.empty() ? std::nullopt : std::optional(out);
        out.append(buffer.data(), static_cast<std::size_t>(size));
    }
    return out;
}

} // namespace sinew::cli
