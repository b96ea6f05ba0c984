#pragma once
#include "sinew/diagnosis/scanner.hpp"

/// Looking for the devices on a link, for `scan` and for `bus` where nobody names any.
namespace sinew::cli {

/// The link with the rate to open a port with that must be given one: that of the plan, or of the first family.
std::string link_to_open(const std::string& word, const diagnosis::ScanPlan& plan);

/// Says on stderr how long it takes and how far it is. Adds to `found`, also where it ends early by an error or Ctrl-C.
/// Returns how many ids were left out, for a question to them could harm somebody.
std::expected<std::size_t, Error> look_for_devices(const std::string& link, const diagnosis::ScanPlan& plan,
                                                   std::vector<diagnosis::Found>& found);

std::unexpected<Error> nobody_answered(const std::string& link);

} // namespace sinew::cli
