#include "sinew/base/user_folders.hpp"
#include "sinew/robot/guardian.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <fmt/format.h>
#include <optional>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

// How others find and ask a guardian.
namespace sinew::robot {
namespace {

constexpr std::string_view prefix = "guard-";
constexpr std::string_view ending = ".sock";

std::filesystem::path socket_of(int pid)
{
    return runtime_folder() / fmt::format("{}{}{}", prefix, pid, ending);
}

/// Nothing when there is none or nobody answers. The sockets of those that were killed are cleared away.
std::optional<std::string> ask(int pid, std::string_view word)
{
    const std::string path = socket_of(pid).string();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path)
        return std::nullopt;
    path.copy(address.sun_path, path.size());
    const link::Fd fd(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        if (errno == ECONNREFUSED)
            ::unlink(path.c_str());
        return std::nullopt;
    }
    const timeval patience{.tv_sec = 5, .tv_usec = 0}; // it may be sending a stop on a slow line
    ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (::send(fd.get(), word.data(), word.size(), MSG_NOSIGNAL) < 0)
        return std::nullopt;
    std::array<char, 8192> answer{};
    const ssize_t size = ::recv(fd.get(), answer.data(), answer.size(), 0);
    return size < 0 ? std::nullopt : std::optional<std::string>({answer.data(), static_cast<std::size_t>(size)});
}

/// What stands before the next `end`, which goes as well.
std::string_view take(std::string_view& text, char end)
{
    const auto at = text.find(end);
    const auto out = text.substr(0, at);
    text = at == std::string_view::npos ? std::string_view{} : text.substr(at + 1);
    return out;
}

} // namespace

std::vector<Guarded> guarded_programs()
{
    std::vector<Guarded> out;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(runtime_folder(), none)) {
        const std::string file = entry.path().filename().string();
        std::string_view name = file;
        if (!name.starts_with(prefix) || !name.ends_with(ending))
            continue;
        name = name.substr(prefix.size(), name.size() - prefix.size() - ending.size());
        Guarded one;
        if (std::from_chars(name.data(), name.data() + name.size(), one.pid).ec != std::errc{})
            continue;
        const auto links = ask(one.pid, "who");
        if (!links)
            continue;
        for (std::size_t at = 0, end = 0; (end = links->find('\n', at)) != std::string::npos; at = end + 1)
            one.links.push_back(links->substr(at, end - at));
        out.push_back(std::move(one));
    }
    return out;
}

std::expected<StoppedProgram, Error> stop_program(int pid)
{
    std::error_code none;
    if (!std::filesystem::exists(socket_of(pid), none))
        return fail(Errc::link_not_found, fmt::format("no guardian watches a program with process id {}", pid));
    const auto answer = ask(pid, "stop");
    if (!answer || answer->empty())
        return fail(Errc::timeout, fmt::format("the guardian of process {} did not answer", pid));
    StoppedProgram out;
    std::string_view rest = *answer;
    out.by_guardian = take(rest, '\n') != "program";
    while (!rest.empty()) {
        std::string_view line = take(rest, '\n');
        const auto outcome = take(line, '\t');
        StoppedBus bus{.link = std::string(take(line, '\t')), .says = std::string(line)};
        if (outcome == "1" || outcome == "2")
            bus.outcome = outcome == "1" ? StoppedBus::Outcome::confirmed : StoppedBus::Outcome::failed;
        out.buses.push_back(std::move(bus));
    }
    return out;
}

} // namespace sinew::robot
