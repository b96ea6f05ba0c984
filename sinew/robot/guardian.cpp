#include "sinew/robot/guardian.hpp"

#include "sinew/base/user_folders.hpp"
#include "sinew/robot/guardian_memory.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <fmt/format.h>
#include <new>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

namespace sinew::robot {
namespace {

using namespace guardian;

std::unexpected<Error> refused(std::string_view what)
{
    return fail(Errc::link_failed, fmt::format("no guardian: {}: {}", what, std::strerror(errno)));
}

std::size_t threads()
{
    std::error_code none;
    std::size_t count = 0;
    for (auto it = std::filesystem::directory_iterator("/proc/self/task", none);
         !none && it != std::filesystem::directory_iterator(); it.increment(none))
        ++count;
    return count;
}

/// Where `sinew stop` finds it. None where there is no such folder: everything else works.
link::Fd listen_at(const std::filesystem::path& path)
{
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = path.string();
    std::error_code none;
    std::filesystem::create_directories(path.parent_path(), none);
    std::filesystem::permissions(path.parent_path(), std::filesystem::perms::owner_all, none);
    if (name.size() >= sizeof address.sun_path)
        return {};
    name.copy(address.sun_path, name.size());
    ::unlink(name.c_str()); // of an earlier process with this number
    link::Fd fd(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (!fd || ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(fd.get(), 4) != 0)
        return {};
    return fd;
}

int handle_of(const link::AnyLink& link)
{
    return std::visit([](const auto& l) { return l->handle(); }, link);
}

std::uint8_t spell(const link::AnyLink& link, const wire::Frame& frame,
                   std::span<std::uint8_t, link::longest_spelling> into)
{
    if (const auto* can = std::get_if<std::unique_ptr<link::CanLink>>(&link))
        return static_cast<std::uint8_t>((*can)->spell(frame, into));
    const auto bytes = frame.bytes().first(std::min(frame.bytes().size(), into.size()));
    std::ranges::copy(bytes, into.begin());
    return static_cast<std::uint8_t>(bytes.size());
}

/// Adapters on USB take a frame at a time; behind any line an answer must not meet the next frame.
std::uint32_t pause_us(const link::AnyLink& link, const wire::Request& request)
{
    const auto state = std::visit([](const auto& l) { return l->state(); }, link);
    const bool can = std::holds_alternative<std::unique_ptr<link::CanLink>>(link);
    const auto time = bus::predict({.can = can, .bit_rate = state.bit_rate}, request).total();
    return static_cast<std::uint32_t>(std::chrono::ceil<std::chrono::microseconds>(time).count());
}

void write_pieces(Pieces& pieces, const link::AnyLink& link, std::span<const wire::Request> stop)
{
    const std::size_t count = std::min(stop.size(), most_pieces);
    for (std::size_t i = 0; i < count; ++i) {
        pieces.all[i].size = spell(link, stop[i].frame, pieces.all[i].bytes);
        pieces.all[i].pause_us = pause_us(link, stop[i]);
    }
    pieces.count = static_cast<std::uint32_t>(count);
}

void write_stop(Bus& bus, const link::AnyLink& link, const StopFrames& frames)
{
    const auto written = bus.written.load(std::memory_order_relaxed) + 1;
    Stop& stop = bus.stop(written);
    // Whoever sees a part of this one knows that the one before is out.
    std::atomic_thread_fence(std::memory_order_release);
    const Duration now = std::chrono::steady_clock::now().time_since_epoch();
    stop.seen_until_ns = (now + std::min(frames.seen_for, Duration::max() - now)).count();
    write_pieces(stop.seen, link, frames.seen);
    write_pieces(stop.unseen, link, frames.unseen);
    bus.written.store(written, std::memory_order_release);
}

} // namespace

std::expected<Guardian, Error> Guardian::start(Settings settings)
{
    if (threads() > 1)
        return fail(Errc::unsupported, "a guardian must be started before the program has threads");
    void* shared = ::mmap(nullptr, sizeof(Memory), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED)
        return refused("no shared memory");
    Guardian out;
    out.memory_ = new (shared) Memory;
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
        return refused("no socket");
    out.socket_ = link::Fd(ends[0]);
    link::Fd other(ends[1]);
    const int program = ::getpid();
    out.path_ = runtime_folder() / fmt::format("guard-{}.sock", program);
    const link::Fd listener = listen_at(out.path_);
    const int child = ::fork();
    if (child < 0)
        return refused("no process");
    if (child == 0) {
        out.socket_.close();
        watch_over(*out.memory_, program, other.get(), listener.get(), settings.patience);
    }
    out.pid_ = child;
    out.exceptions_ = std::uncaught_exceptions();
    return out;
}

Guardian::Guardian(Guardian&& other) noexcept
    : memory_(std::exchange(other.memory_, nullptr)), socket_(std::move(other.socket_)),
      pid_(std::exchange(other.pid_, -1)), exceptions_(other.exceptions_), seen_beats_(other.seen_beats_),
      seen_at_(other.seen_at_), dead_(other.dead_), path_(std::exchange(other.path_, {}))
{
}

Guardian& Guardian::operator=(Guardian&& other) noexcept
{
    if (this != &other) {
        dismiss();
        memory_ = std::exchange(other.memory_, nullptr);
        socket_ = std::move(other.socket_);
        pid_ = std::exchange(other.pid_, -1);
        exceptions_ = other.exceptions_;
        seen_beats_ = other.seen_beats_;
        seen_at_ = other.seen_at_;
        dead_ = other.dead_;
        path_ = std::exchange(other.path_, {});
    }
    return *this;
}

Guardian::~Guardian()
{
    dismiss();
}

void Guardian::dismiss() noexcept
{
    if (memory_ == nullptr)
        return;
    const bool is_asked_for = std::uncaught_exceptions() <= exceptions_;
    if (pid_ > 0 && !dead_) {
        const Letter letter{.word = Word::dismiss};
        if (is_asked_for)
            static_cast<void>(::send(socket_.get(), &letter, sizeof letter, MSG_NOSIGNAL));
        socket_.close(); // and without that word it stops the motors
        while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR)
            ;
    }
    ::unlink(path_.c_str());
    ::munmap(memory_, sizeof(Memory));
    memory_ = nullptr;
    pid_ = -1;
}

std::expected<void, Error> Guardian::watch(std::size_t bus, std::string_view name, const link::AnyLink& link,
                                           const StopFrames& stop)
{
    if (bus >= most_buses || std::max(stop.seen.size(), stop.unseen.size()) > most_pieces)
        return fail(Errc::out_of_range, fmt::format("a guardian watches up to {} buses with up to {} frames each",
                                                    most_buses, most_pieces));
    std::array<std::uint8_t, link::longest_spelling> probe{};
    const int fd = handle_of(link);
    if (fd < 0 || (!stop.seen.empty() && spell(link, stop.seen.front().frame, probe) == 0))
        return fail(Errc::unsupported, fmt::format("a guardian cannot reach {}: it ends with this process", name));

    Bus& kept = memory_->buses[bus];
    kept.link.fill('\0');
    name.copy(kept.link.data(), kept.link.size() - 1);
    write_stop(kept, link, stop);

    Letter letter{.word = Word::watch, .bus = static_cast<std::uint8_t>(bus)};
    iovec place{.iov_base = &letter, .iov_len = sizeof letter};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    msghdr message{};
    message.msg_iov = &place;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(header), &fd, sizeof fd);
    while (::sendmsg(socket_.get(), &message, MSG_NOSIGNAL) < 0)
        if (errno != EINTR)
            return refused("it has ended");
    return {};
}

// NOLINTNEXTLINE(bugprone-exception-escape): only a variant without a value throws, and no link is moved from here
void Guardian::update(std::size_t bus, const link::AnyLink& link, const StopFrames& stop) noexcept
{
    if (bus < most_buses && memory_->buses[bus].link.front() != '\0')
        write_stop(memory_->buses[bus], link, stop);
}

void Guardian::forget(std::size_t bus) noexcept
{
    const Letter letter{.word = Word::forget, .bus = static_cast<std::uint8_t>(bus)};
    static_cast<void>(::send(socket_.get(), &letter, sizeof letter, MSG_NOSIGNAL | MSG_DONTWAIT));
}

void Guardian::beat() noexcept
{
    memory_->beats.fetch_add(1, std::memory_order_relaxed);
}

void Guardian::rest() noexcept
{
    memory_->beats.store(0, std::memory_order_relaxed);
}

bool Guardian::stop_asked() const noexcept
{
    return memory_->stop_asked.load(std::memory_order_acquire);
}

void Guardian::stop_begun() noexcept
{
    memory_->stop_begun.store(true, std::memory_order_release);
}

void Guardian::stopped(std::size_t bus, StoppedBus::Outcome outcome, std::string_view says) noexcept
{
    if (bus >= most_buses)
        return;
    auto& kept = memory_->buses[bus];
    kept.says.fill('\0');
    says.copy(kept.says.data(), kept.says.size() - 1);
    kept.outcome.store(static_cast<std::uint8_t>(outcome), std::memory_order_release);
}

void Guardian::stop_done() noexcept
{
    memory_->stop_done.store(true, std::memory_order_release);
    memory_->stop_asked.store(false, std::memory_order_release);
}

bool Guardian::is_alive()
{
    // It beats ten times a second; how long this program itself was kept waiting says nothing about it.
    constexpr auto doubtful = std::chrono::milliseconds{500};
    if (dead_)
        return false;
    const auto beats = memory_->watch_beats.load(std::memory_order_relaxed);
    const auto now = std::chrono::steady_clock::now();
    if (beats != seen_beats_ || seen_at_ == std::chrono::steady_clock::time_point{}) {
        seen_beats_ = beats;
        seen_at_ = now;
    } else if (now - seen_at_ > doubtful) {
        // ECHILD: the program lets the system reap its children, or did it itself.
        const int ended = ::waitpid(pid_, nullptr, WNOHANG);
        dead_ = ended == pid_ || (ended < 0 && errno == ECHILD);
        seen_at_ = now;
    }
    return !dead_;
}

} // namespace sinew::robot
