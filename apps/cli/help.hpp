#pragma once
#include "apps/cli/verb.hpp"

namespace sinew::cli {

std::string help();
std::string help(const Verb& verb);
/// What the help explains beside the verbs: `sinew help units`.
struct HelpTopic {
    std::string_view name;  ///< "exit-codes"
    std::string_view title; ///< "EXIT CODES"
    std::string_view says;
    std::vector<std::pair<std::string, std::string>> (*rows)();
};
std::span<const HelpTopic> help_topics();
std::string help(const HelpTopic& topic);

/// All verbs with what they take, for programs.
std::string help_json();

/// "sinew scan LINK [options]"
std::string usage(const Verb& verb);

} // namespace sinew::cli
