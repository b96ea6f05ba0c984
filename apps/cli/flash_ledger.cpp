#include "apps/cli/flash_ledger.hpp"

#include "apps/cli/new_file.hpp"
#include "sinew/config/device_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

namespace sinew::cli {
namespace {

bool is_counted(const Device& device)
{
    return !sim::is_simulated(device.link) && !record::is_replay(device.link);
}

/// "sam-3-serial-dev-ttyUSB0": what a table of the file may be called.
std::string name_of(const Device& device, int id)
{
    const auto uri = link::parse_uri(device.link);
    std::string link = uri ? uri->scheme + '-' + uri->target : device.link;
    std::ranges::replace_if(link, [](unsigned char c) { return !std::isalnum(c) && c != '-' && c != '_'; }, '-');
    link.erase(std::ranges::unique(link, [](char a, char b) { return a == '-' && b == '-'; }).begin(), link.end());
    return fmt::format("{}-{}-{}", device.family->name, id, link);
}

std::expected<config::DeviceFile, Error> read(const std::filesystem::path& path)
{
    std::error_code unknown;
    if (!std::filesystem::exists(path, unknown))
        return config::DeviceFile{.path = path.string()};
    return config::read_device_file(path);
}

std::unexpected<Error> refused(const std::filesystem::path& path, int error)
{
    return fail(Errc::bad_argument, fmt::format("{}: {}", path.string(), std::strerror(error)));
}

/// Changes the ledger while nobody else does.
template <class Change>
std::expected<void, Error> change(const Change& what)
{
    const auto path = flash_ledger_path();
    if (!path)
        return fail(Errc::bad_argument, "neither XDG_STATE_HOME nor HOME says where it is");
    std::error_code failed;
    std::filesystem::create_directories(path->parent_path(), failed);
    auto lock_path = *path;
    lock_path += ".lock";
    const link::Fd lock(::open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
    if (lock.get() < 0 || ::flock(lock.get(), LOCK_EX) != 0)
        return refused(lock_path, errno);
    auto ledger = read(*path);
    if (!ledger)
        return std::unexpected(ledger.error());
    what(*ledger);
    auto file = NewFile::make(*path);
    if (!file)
        return std::unexpected(file.error());
    if (auto written = file->write(config::to_toml(*ledger)); !written)
        return written;
    return file->keep();
}

config::DeviceEntry& entry_of(config::DeviceFile& ledger, const Device& device, int id)
{
    const auto name = name_of(device, id);
    auto found = std::ranges::find(ledger.devices, name, &config::DeviceEntry::name);
    if (found == ledger.devices.end())
        found = ledger.devices.insert(ledger.devices.end(), {.name = name});
    return *found;
}

void set_writes(config::DeviceEntry& entry, const Device& device, int id, std::int64_t writes)
{
    entry.facts = {{"link", device.link, {}},
                   {"family", std::string(device.family->name), {}},
                   {"id", static_cast<std::int64_t>(id), {}},
                   {"writes", writes, {}}};
}

void complain(const std::expected<void, Error>& outcome)
{
    if (!outcome)
        fmt::print(stderr, "sinew: the write is not in the ledger of flash writes: {}\n", to_sentence(outcome.error()));
}

} // namespace

std::optional<std::filesystem::path> flash_ledger_path()
{
    const auto folder = [](const char* name) -> std::filesystem::path {
        const char* value = std::getenv(name);
        return value != nullptr ? value : "";
    };
    // The specification of XDG wants relative paths to be ignored.
    if (const auto state = folder("XDG_STATE_HOME"); state.is_absolute())
        return state / "sinew" / "flash-writes.toml";
    if (const auto home = folder("HOME"); home.is_absolute())
        return home / ".local" / "state" / "sinew" / "flash-writes.toml";
    return std::nullopt;
}

std::optional<std::int64_t> flash_writes(const Device& device)
{
    const auto path = flash_ledger_path();
    if (!path || !is_counted(device))
        return std::nullopt;
    const auto ledger = read(*path);
    if (!ledger)
        return std::nullopt;
    const auto* entry = ledger->find(name_of(device, device.id));
    return entry != nullptr ? entry->whole("writes") : std::optional<std::int64_t>(0);
}

std::expected<void, Error> write_once(bus::Bus& bus, const Device& device, const wire::Request& request)
{
    const auto sent = ask_counted(bus, device, request);
    return sent || may_pass(sent.error().code) ? std::expected<void, Error>{} : std::unexpected(sent.error());
}

void count_flash_write(const Device& device)
{
    if (!is_counted(device))
        return;
    complain(change([&](config::DeviceFile& ledger) {
        auto& entry = entry_of(ledger, device, device.id);
        set_writes(entry, device, device.id, entry.whole("writes").value_or(0) + 1);
    }));
}

void move_flash_writes(const Device& device, int new_id)
{
    if (!is_counted(device))
        return;
    complain(change([&](config::DeviceFile& ledger) {
        const auto writes = entry_of(ledger, device, device.id).whole("writes").value_or(0);
        std::erase_if(ledger.devices, [&](const auto& one) { return one.name == name_of(device, device.id); });
        set_writes(entry_of(ledger, device, new_id), device, new_id, writes);
    }));
}

std::expected<wire::Values, Error> ask_counted(bus::Bus& bus, const Device& device, const wire::Request& request)
{
    auto values = ask(bus, request);
    const bool carried_out = values || values.error().code == Errc::timeout || values.error().code >= Errc::bad_length;
    if (request.message->info.access == wire::Access::flash && carried_out)
        count_flash_write(device);
    return values ? std::move(values) : std::unexpected(about(device, values.error()));
}

} // namespace sinew::cli
