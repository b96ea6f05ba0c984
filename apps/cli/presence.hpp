#pragma once
#include "apps/cli/session.hpp"

namespace sinew::cli {

/// The read that every device of the family answers, for a device like this one at another id.
std::expected<wire::Request, Error> probe(const Device& like, int id);

/// Whether somebody answers at `id`. An answer that cannot be understood is one as well: two devices of one id give it.
/// Fails for what is wrong with the link, and when it is interrupted.
std::expected<bool, Error> somebody_at(bus::Bus& bus, const Device& like, int id);

/// The requests as they would go out, for `--dry-run`: a line each, or an array with `--json`.
void show_unsent(const Words& words, const Device& device, std::span<const wire::Request> requests);

inline constexpr Option dry_run_option{"--dry-run", "", "show the bytes and send nothing"};

} // namespace sinew::cli
