#pragma once
#include "apps/cli/present.hpp"
#include "apps/cli/session.hpp"

namespace sinew::cli {

/// What one read-message brought.
struct Read {
    const wire::MessageInfo* message = nullptr;
    std::expected<std::vector<Shown>, Error> values;
};

/// Every read that needs to be told nothing. Where there are a quick and a standard one for the same thing the quick
/// one says less and is left out.
std::expected<std::vector<wire::Request>, Error> all_reads(const Device& device);

/// Sends the requests one after the other and goes on past failures; a lost link ends it.
std::vector<Read> read_all(const Device& device, bus::Bus& bus, std::span<const wire::Request> requests);

/// As a table or as JSON. The exit code is that of the first failure.
Outcome print_readings(const Words& words, const Device& device, const std::vector<Read>& readings);

Json to_json(const std::vector<Read>& readings);

} // namespace sinew::cli
