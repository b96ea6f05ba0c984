#pragma once
#include "sinew/base/bytes.hpp"
#include "sinew/config/reader.hpp"

namespace sinew::config {

/// Reads `[pose.…]` and `[sequence.…]` into a robot file that has its joints already, and checks them: joints and names
/// that are not there, positions beyond limits, steps that make no sense, calls that never end.
void read_motion(Reader& reader, const toml::table& document, RobotFile& file);

/// Finds the sequences that steps call, and sees to it that no call leads back to where it began.
void check_calls(Reader& reader, RobotFile& file);

/// The end of a sentence about a name that is not among these.
template <class Named>
std::string or_nearest(std::string_view word, const std::vector<Named>& all)
{
    std::vector<std::string_view> names;
    for (const Named& one : all)
        names.emplace_back(one.name);
    const std::string suggestion = did_you_mean(word, names);
    return suggestion.empty() ? "." : suggestion;
}

} // namespace sinew::config
