#pragma once
#include "apps/cli/verb.hpp"

namespace sinew::cli {

/// Asks before something that moves or wears out a device. True with `--yes` or when the person says yes; false on no;
/// `bad_argument` where nobody can be asked.
std::expected<bool, Error> confirm(const Words& words, std::string_view what);

} // namespace sinew::cli
