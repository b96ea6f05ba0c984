#pragma once
#include "apps/cli/verb.hpp"

namespace sinew::cli {

std::string help();
std::string help(const Verb& verb);
/// "sinew scan LINK [options]"
std::string usage(const Verb& verb);

} // namespace sinew::cli
