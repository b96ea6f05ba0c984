#pragma once
#include "sinew/base/bytes.hpp"
#include "sinew/sim/firmware/device.hpp"

#include <algorithm>
#include <cstdint>
#include <expected>
#include <fmt/format.h>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

/// What a device keeps without power, value by value: each family has a table of it, from which a flash file is written
/// and read.
namespace sinew::sim {

/// One value of the settings `S`; what stands in a file must be from `low` to `high`.
template <class S>
struct KeptRow {
    std::string_view key;
    std::int64_t low = 0;
    std::int64_t high = 0;
    void (*set)(S&, std::int64_t) = nullptr;
    std::int64_t (*get)(const S&) = nullptr;
};

/// `Place` is a function from the settings to a reference to the value.
template <class S, auto Place>
consteval KeptRow<S> kept(std::string_view key, std::int64_t low, std::int64_t high)
{
    return {key, low, high,
            [](S& settings, std::int64_t value) {
                auto& place = Place(settings);
                place = static_cast<std::remove_reference_t<decltype(place)>>(value);
            },
            [](const S& settings) { return static_cast<std::int64_t>(Place(settings)); }};
}

/// How often the flash was written; stands beside the values in the file.
inline constexpr std::string_view kept_writes = "writes";
inline constexpr std::int64_t kept_writes_max = 0xFFFF'FFFF;

template <class S>
std::vector<KeptValue> kept_values(std::span<const KeptRow<S>> rows, const S& settings, std::uint32_t writes)
{
    std::vector<KeptValue> out{{kept_writes, writes}};
    for (const KeptRow<S>& row : rows)
        out.push_back({row.key, row.get(settings)});
    return out;
}

/// Settings from a file; what it does not name stays as it is in `S`.
template <class S>
struct Restored {
    S settings;
    std::uint32_t writes = 0;
};

/// `bad_file` at the place of the first key that is not known or whose value makes no sense.
template <class S>
std::expected<Restored<S>, Error> read_kept(const config::FlashFile& file, const config::FlashJoint& joint,
                                            std::span<const KeptRow<S>> rows, const S& delivered)
{
    Restored<S> out{delivered};
    for (const config::Setting& setting : joint.values) {
        const bool is_writes = setting.key == kept_writes;
        const auto row = std::ranges::find(rows, std::string_view(setting.key), &KeptRow<S>::key);
        if (!is_writes && row == rows.end()) {
            std::vector<std::string_view> names{kept_writes};
            for (const KeptRow<S>& one : rows)
                names.push_back(one.key);
            const std::string near = did_you_mean(setting.key, names);
            return config::fail_at(file, setting.at,
                                   fmt::format("the {} of {} keeps no '{}'{}", joint.family.value, joint.name,
                                               setting.key, near.empty() ? "." : near));
        }
        const std::int64_t low = is_writes ? 0 : row->low;
        const std::int64_t high = is_writes ? kept_writes_max : row->high;
        const auto* value = std::get_if<std::int64_t>(&setting.value);
        if (value == nullptr || *value < low || *value > high)
            return config::fail_at(file, setting.at,
                                   fmt::format("{} must be a whole number from {} to {}.", setting.key, low, high));
        if (is_writes)
            out.writes = static_cast<std::uint32_t>(*value);
        else
            row->set(out.settings, *value);
    }
    return out;
}

} // namespace sinew::sim
