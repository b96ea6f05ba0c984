#include "apps/cli/sim_control.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/base/user_folders.hpp"
#include "sinew/sim/console.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <vector>

namespace sinew::cli {
namespace {

constexpr std::string_view prefix = "sim-";
constexpr std::string_view ending = ".sock";
constexpr std::size_t longest = 64 * 1024;  // one message each way; the first byte of an answer is + or -
constexpr std::ptrdiff_t most_waiting = 32; // who asks nothing gives way to who comes later
constexpr char good = '+';
constexpr char bad = '-';
constexpr std::string_view sniff_word = "sniff "; // then the bus, a newline and the robot file

std::unexpected<Error> refused(std::string_view what, const std::filesystem::path& path)
{
    return fail(Errc::link_failed, fmt::format("{} {}: {}", what, path.string(), std::strerror(errno)));
}

std::expected<sockaddr_un, Error> address_of(const std::filesystem::path& path)
{
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = path.string();
    if (name.size() >= sizeof address.sun_path)
        return fail(Errc::link_failed, fmt::format("{} is too long a name for a socket; set XDG_RUNTIME_DIR", name));
    name.copy(address.sun_path, name.size());
    return address;
}

const sockaddr* generic(const sockaddr_un& address)
{
    return reinterpret_cast<const sockaddr*>(&address);
}

/// Connected to the simulator of that socket; nothing when it has ended.
link::Fd connect_to(const std::filesystem::path& path)
{
    const auto address = address_of(path);
    link::Fd fd(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    if (!address || !fd || ::connect(fd.get(), generic(*address), sizeof *address) != 0)
        return {};
    return fd;
}

/// Two ways to write one file are one.
std::string canonical(const std::string& path)
{
    std::error_code none;
    const auto out = std::filesystem::weakly_canonical(path, none);
    return none ? path : out.string();
}

struct Running {
    std::string pid;
    link::Fd fd;
};

/// All simulators of this user. The sockets of those that were killed are cleared away.
std::vector<Running> running()
{
    std::vector<Running> all;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(runtime_folder(), none)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(prefix) || !name.ends_with(ending))
            continue;
        if (link::Fd fd = connect_to(entry.path()))
            all.push_back({name.substr(prefix.size(), name.size() - prefix.size() - ending.size()), std::move(fd)});
        else if (errno == ECONNREFUSED)
            std::filesystem::remove(entry.path(), none);
    }
    return all;
}

} // namespace

std::expected<std::unique_ptr<SimControl>, Error> SimControl::open(sim::RealTimeSimulator& simulator, bool prompt,
                                                                   std::function<void()> on_quit)
{
    std::unique_ptr<SimControl> control(new SimControl(simulator, prompt, std::move(on_quit)));
    std::error_code code;
    std::filesystem::create_directories(runtime_folder(), code);
    std::filesystem::permissions(runtime_folder(), std::filesystem::perms::owner_all, code);
    const auto path = runtime_folder() / fmt::format("{}{}{}", prefix, ::getpid(), ending);
    const auto address = address_of(path);
    if (!address)
        return std::unexpected(address.error());
    ::unlink(path.c_str()); // of an earlier process with this number
    control->socket_ = link::Fd(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (!control->socket_ || ::bind(control->socket_.get(), generic(*address), sizeof *address) != 0 ||
        ::listen(control->socket_.get(), 4) != 0)
        return refused("cannot listen on", path);
    control->path_ = path;
    control->zero_ = std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now()) -
                     simulator.world().now().time_since_epoch();
    control->handles_ = {link::Handle{control->socket_.get()}, link::Handle{prompt ? STDIN_FILENO : -1}};
    return control;
}

void SimControl::show_prompt()
{
    if (!prompts_)
        return;
    fmt::print("sim> ");
    std::fflush(stdout);
}

SimControl::~SimControl()
{
    simulator_->set_tap(nullptr);
    if (!path_.empty())
        ::unlink(path_.c_str());
}

void SimControl::serve()
{
    serve_socket();
    if (prompts_)
        serve_prompt();
    tell_lateness();
}

void SimControl::hear(std::string_view sentence)
{
    fmt::print(stderr, "sinew sim: {}\n", sentence);
}

// Who connects may be long in asking, and the robot does not wait for it.
void SimControl::serve_socket()
{
    while (link::Fd client{::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC)})
        waiting_.push_back(std::move(client));
    if (std::ssize(waiting_) > most_waiting)
        waiting_.erase(waiting_.begin(), waiting_.end() - most_waiting);
    std::string line;
    for (link::Fd& client : waiting_) {
        line.resize(longest);
        const ssize_t size = ::recv(client.get(), line.data(), line.size(), MSG_DONTWAIT);
        if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
            continue;
        if (size > 0)
            serve_visitor(std::move(client), std::string_view(line).substr(0, static_cast<std::size_t>(size)));
        client = {};
    }
    std::erase_if(waiting_, [](const link::Fd& client) { return !client; });
    handles_.resize(2);
    for (const link::Fd& client : waiting_)
        handles_.push_back({client.get()});
}

void SimControl::serve_visitor(link::Fd client, std::string_view line)
{
    const bool sniffs = line.starts_with(sniff_word);
    const auto answer =
        sniffs ? begin_sniffing(line.substr(sniff_word.size())) : sim::respond(simulator_->world(), line);
    const std::string reply = answer ? good + *answer : bad + to_sentence(answer.error());
    static_cast<void>(::send(client.get(), reply.data(), std::min(reply.size(), longest), MSG_NOSIGNAL));
    if (!sniffs || !answer)
        return;
    sniffers_.push_back({std::move(client), *answer, {}});
    simulator_->set_tap([this](const auto& passed) { pass_on(passed); });
}

std::expected<std::string, Error> SimControl::begin_sniffing(std::string_view words)
{
    const auto end = std::min(words.find('\n'), words.size());
    if (canonical(simulator_->world().file().path) != words.substr(std::min(end + 1, words.size())))
        return fail(Errc::link_not_found, "this simulator runs another robot file");
    const auto bus = simulator_->world().find_bus(words.substr(0, end));
    if (!bus)
        return std::unexpected(bus.error());
    return (*bus)->name;
}

void SimControl::pass_on(const sim::RealTimeSimulator::Passed& passed)
{
    record::Captured captured{.at = zero_ + passed.at.time_since_epoch(),
                              .bus = passed.bus->bus,
                              .family = std::string(passed.bus->family),
                              .direction = passed.direction};
    if (passed.frame != nullptr) {
        captured.kind = record::Captured::Kind::can;
        captured.frame = *passed.frame;
    } else {
        captured.bytes.assign(passed.bytes.begin(), passed.bytes.end());
    }
    std::erase_if(sniffers_, [&](Sniffer& one) {
        std::string piece;
        if (one.bus != captured.bus || !one.writer.add(captured, piece))
            return false;
        // One that does not keep up loses frames; the robot does not wait for it.
        const auto sent = ::send(one.fd.get(), piece.data(), piece.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        return sent < 0 && errno != EAGAIN && errno != EWOULDBLOCK;
    });
}

void SimControl::serve_prompt()
{
    pollfd ready{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    if (::poll(&ready, 1, 0) <= 0)
        return;
    std::array<char, 512> in;
    const ssize_t size = ::read(STDIN_FILENO, in.data(), in.size());
    if (size <= 0) { // Ctrl-D
        prompts_ = false;
        handles_[1].fd = -1;
        on_quit_();
        return;
    }
    typed_.append(in.data(), static_cast<std::size_t>(size));
    for (auto end = typed_.find('\n'); end != std::string::npos; end = typed_.find('\n')) {
        const std::string line = typed_.substr(0, end);
        typed_.erase(0, end + 1);
        if (line == "quit" || line == "exit") {
            on_quit_();
            return;
        }
        const auto answer = sim::respond(simulator_->world(), line);
        fmt::print("{}", answer ? *answer : to_sentence(answer.error()) + '\n');
        fmt::print("sim> ");
    }
    std::fflush(stdout);
}

// Said when it has doubled, so that a machine that is always too slow does not fill the terminal.
void SimControl::tell_lateness()
{
    const std::uint64_t late = simulator_->late();
    if (late == 0 || late < 2 * late_told_)
        return;
    late_told_ = late;
    fmt::print(stderr, "sinew sim: this machine cannot keep pace: {} {} answered more than 10 ms late\n", late,
               late == 1 ? "request was" : "requests were");
}

std::expected<std::string, Error> ask_simulator(std::optional<std::int64_t> pid, std::string_view line)
{
    auto all = running();
    std::vector<std::string_view> pids;
    for (const Running& one : all)
        pids.push_back(one.pid);
    if (all.empty())
        return fail(Errc::link_not_found, "no simulator is running; start one with: sinew sim");
    if (!pid && all.size() > 1)
        return fail(Errc::bad_argument, fmt::format("{} simulators are running; say which with --pid: {}", all.size(),
                                                    fmt::join(pids, ", ")));
    const auto found = pid ? std::ranges::find(all, std::to_string(*pid), &Running::pid) : all.begin();
    if (found == all.end())
        return fail(Errc::link_not_found,
                    fmt::format("no simulator has the process id {}; there are: {}", *pid, fmt::join(pids, ", ")));
    if (::send(found->fd.get(), line.data(), line.size(), MSG_NOSIGNAL) < 0)
        return fail(Errc::link_lost, "the simulator ended");
    const timeval patience{.tv_sec = 2, .tv_usec = 0};
    ::setsockopt(found->fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    std::string reply(longest, '\0');
    const ssize_t size = ::recv(found->fd.get(), reply.data(), reply.size(), 0);
    if (size <= 0)
        return fail(Errc::timeout, "the simulator gave no answer within 2 s");
    reply.resize(static_cast<std::size_t>(size));
    if (reply.front() == bad)
        return fail(Errc::bad_argument, reply.substr(1));
    return reply.substr(1);
}

std::expected<link::Fd, Error> sniff_simulator(const std::string& robot, std::string_view bus)
{
    auto why = fail(Errc::link_not_found,
                    fmt::format("no simulator of {} is running; start it with: sinew sim {}", robot, robot));
    const std::string line = fmt::format("{}{}\n{}", sniff_word, bus, canonical(robot));
    for (auto& one : running()) {
        if (::send(one.fd.get(), line.data(), line.size(), MSG_NOSIGNAL) < 0)
            continue;
        std::string reply(longest, '\0');
        const timeval patience{.tv_sec = 2, .tv_usec = 0};
        ::setsockopt(one.fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        const ssize_t size = ::recv(one.fd.get(), reply.data(), reply.size(), 0);
        if (size > 0 && reply.front() == good)
            return std::move(one.fd);
        reply.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
        if (reply.find("another robot file") == std::string::npos && size > 0)
            why = fail(Errc::link_not_found, reply.substr(1));
    }
    return why;
}

} // namespace sinew::cli
