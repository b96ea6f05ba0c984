#pragma once
#include "sinew/base/bytes.hpp"
#include "sinew/family/option.hpp"

#include <algorithm>
#include <expected>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// From the settings of a robot file into the struct that a table of options describes.
namespace sinew {

template <class Range, class Name>
std::vector<std::string_view> names_of(const Range& range, Name name)
{
    std::vector<std::string_view> names;
    for (const auto& one : range)
        names.push_back(name(one));
    return names;
}

/// "sam has no model 'SAM-61', did you mean SAM-160? It has SAM-5, …."
inline std::string no_such(std::string_view owner, std::string_view kind, std::string_view word,
                           const std::vector<std::string_view>& names)
{
    const std::string near = did_you_mean(word, names);
    return fmt::format("{} has no {} '{}'{} It has {}.", owner, kind, word, near.empty() ? "." : near,
                       fmt::join(names, ", "));
}

/// Sets every setting of a table by its option. `bad_file` at the place of the first that `owner` does not have or that
/// has no sensible value; the target is half changed then.
template <class Target>
std::expected<void, Error> apply(const config::RobotFile& file, const std::vector<config::Setting>& settings,
                                 std::span<const Option<Target>> table, std::string_view owner, std::string_view kind,
                                 Target& target)
{
    for (const config::Setting& setting : settings) {
        const auto option = std::ranges::find_if(table, [&](const auto& one) { return one.key == setting.key; });
        if (option == table.end())
            return config::fail_at(
                file, setting.at,
                no_such(owner, kind, setting.key, names_of(table, [](const auto& one) { return one.key; })));
        if (!option->set(target, setting.value))
            return config::fail_at(file, setting.at, fmt::format("{} must be {}.", setting.key, option->says));
    }
    return {};
}

} // namespace sinew
