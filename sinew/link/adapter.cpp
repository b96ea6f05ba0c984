#include "sinew/link/adapter.hpp"

#include <algorithm>
#include <charconv>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <grp.h>
#include <linux/serial.h>
#include <linux/tty_flags.h>
#include <string_view>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

namespace sinew::link {
namespace {

namespace fs = std::filesystem;

/// Calls `visit` with every entry. What cannot be listed has none: processes and devices go while we look.
template <class Visit>
void for_each(const fs::path& folder, Visit visit)
{
    std::error_code error;
    for (fs::directory_iterator at{folder, error}, end; !error && at != end; at.increment(error))
        visit(at->path());
}

/// Where symlinks lead; the path itself where nothing is.
std::string resolved(const fs::path& path)
{
    std::error_code none;
    const auto there = fs::canonical(path, none);
    return none ? path.string() : there.string();
}

std::string first_line(const fs::path& path)
{
    std::ifstream file{path};
    std::string line;
    std::getline(file, line);
    return line;
}

std::optional<int> number(std::string_view text, int base = 10)
{
    int value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    return problem == std::errc{} && end != text.data() ? std::optional{value} : std::nullopt;
}

Holder holder(int pid, const Roots& roots)
{
    return {.pid = pid, .program = first_line(fs::path{roots.proc} / std::to_string(pid) / "comm")};
}

std::vector<Holder> find_holders(const std::string& device, const Roots& roots)
{
    std::vector<Holder> found;
    for_each(roots.proc, [&](const fs::path& process) {
        const auto pid = number(process.filename().string());
        bool holds = false;
        if (pid)
            for_each(process / "fd", [&](const fs::path& fd) {
                std::error_code none;
                holds = holds || fs::read_symlink(fd, none) == device;
            });
        if (holds)
            found.push_back(holder(*pid, roots));
    });
    std::ranges::sort(found, {}, &Holder::pid);
    return found;
}

/// The flags of a port of the board, as the kernel's serial core shows them; "0x10000040".
std::optional<bool> low_latency_of(const fs::path& tty)
{
    const std::string flags = first_line(tty / "flags");
    if (!flags.starts_with("0x"))
        return std::nullopt;
    const auto value = number(std::string_view{flags}.substr(2), 16);
    return value ? std::optional{(*value & ASYNC_LOW_LATENCY) != 0} : std::nullopt;
}

fs::path tty_folder(const std::string& device, const Roots& roots)
{
    return fs::path{roots.sys} / "class/tty" / fs::path{device}.filename();
}

std::string group_of(const struct stat& file)
{
    const group* owner = (file.st_mode & S_IWGRP) != 0 && file.st_gid != 0 ? ::getgrgid(file.st_gid) : nullptr;
    return owner != nullptr ? owner->gr_name : "";
}

std::string words(const Holder& one)
{
    return one.program.empty() ? fmt::format("pid {}", one.pid) : fmt::format("{} (pid {})", one.program, one.pid);
}

} // namespace

Adapter look_at_adapter(const std::string& device, const Roots& roots)
{
    Adapter found{.device = resolved(device)};
    struct stat file{};
    found.is_there = ::stat(found.device.c_str(), &file) == 0;
    if (!found.is_there)
        return found;
    found.may_open = ::faccessat(AT_FDCWD, found.device.c_str(), R_OK | W_OK, AT_EACCESS) == 0;
    found.group = group_of(file);
    found.by_id = find_by_id(device, roots);
    found.holders = find_holders(found.device, roots);

    const fs::path tty = tty_folder(found.device, roots);
    found.serial_number = find_serial_number(device, roots);
    std::error_code none;
    found.driver = fs::read_symlink(tty / "device/driver", none).filename().string();
    for (const auto* place : {"device/latency_timer", "latency_timer"})
        if (!found.latency_timer_ms)
            found.latency_timer_ms = number(first_line(tty / place));
    found.low_latency = low_latency_of(tty);
    return found;
}

DriverSettings driver_settings(int fd)
{
    DriverSettings found;
    if (serial_struct serial{}; ::ioctl(fd, TIOCGSERIAL, &serial) == 0)
        found.low_latency = (serial.flags & ASYNC_LOW_LATENCY) != 0;
    if (serial_rs485 rs485{}; ::ioctl(fd, TIOCGRS485, &rs485) == 0)
        found.rs485 = (rs485.flags & SER_RS485_ENABLED) != 0;
    return found;
}

std::string find_by_id(const std::string& device, const Roots& roots)
{
    const std::string wanted = resolved(device);
    std::string found;
    for_each(fs::path{roots.dev} / "serial/by-id", [&](const fs::path& name) {
        if (resolved(name) == wanted)
            found = name.string();
    });
    return found;
}

std::string find_serial_number(const std::string& device, const Roots& roots)
{
    // The folder of the USB device is a few floors above that of its port.
    std::error_code none;
    std::error_code no_product;
    fs::path at = fs::canonical(tty_folder(resolved(device), roots) / "device", none);
    for (; !none && at.has_relative_path(); at = at.parent_path())
        if (fs::exists(at / "idProduct", no_product))
            return first_line(at / "serial");
    return {};
}

std::optional<Holder> lock_holder(const std::string& device, const Roots& roots)
{
    struct stat file{};
    if (::stat(device.c_str(), &file) != 0)
        return std::nullopt;
    // "1: FLOCK  ADVISORY  WRITE 1234 00:1a:7 0 EOF", see proc_locks(5); a lock that is only waited for begins with
    // "1: ->".
    const std::string wanted = fmt::format(" {:02x}:{:02x}:{} ", major(file.st_dev), minor(file.st_dev), file.st_ino);
    std::ifstream locks{fs::path{roots.proc} / "locks"};
    for (std::string line; std::getline(locks, line);) {
        const auto place = line.find(wanted);
        if (place == std::string::npos || line.find(": FLOCK ") == std::string::npos)
            continue;
        const auto before = line.rfind(' ', place - 1);
        return holder(number(std::string_view{line}.substr(before + 1)).value_or(0), roots);
    }
    return std::nullopt;
}

std::string who_holds(const std::string& device, const Roots& roots)
{
    // The holder of a lock that lives in another container has no number here.
    if (const auto one = lock_holder(device, roots); one && one->pid > 0)
        return words(*one);
    std::vector<std::string> all;
    for (const Holder& one : find_holders(resolved(device), roots))
        all.push_back(words(one));
    return fmt::format("{}", fmt::join(all, ", "));
}

} // namespace sinew::link
