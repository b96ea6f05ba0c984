#pragma once
#include "apps/cli/session.hpp"

#include <filesystem>

/// How often this host has written the flash of each device: flash wears out, and no device counts for itself.
///
/// The ledger is a file under the state of the user ($XDG_STATE_HOME, else ~/.local/state), `sinew/flash-writes.toml`,
/// written whole beside its place. A device goes by its link, family and id, for none says a serial number. Those of a
/// simulator inside the command are gone with it and are not counted.
namespace sinew::cli {

/// Nothing where there is neither XDG_STATE_HOME nor HOME.
std::optional<std::filesystem::path> flash_ledger_path();

/// What the ledger has of this device; nothing where it cannot be known (simulated, or the file cannot be read).
std::optional<std::int64_t> flash_writes(const Device& device);

/// As `ask`. A message that writes flash is counted once it may have been carried out; where the ledger cannot be
/// written that is said on stderr, for the write has happened.
std::expected<wire::Values, Error> ask_counted(bus::Bus& bus, const Device& device, const wire::Request& request);
/// The same where another look tells whether it was carried out: an answer that is missing or spoiled is no error.
std::expected<void, Error> write_once(bus::Bus& bus, const Device& device, const wire::Request& request);
/// Counts one write.
void count_flash_write(const Device& device);
/// The count of a device that answers at another id from now on.
void move_flash_writes(const Device& device, int new_id);

/// Writes of the flash until it may fail, where the document says so (L310 of SAM's).
inline constexpr std::int64_t documented_flash_writes = 10'000;

} // namespace sinew::cli
