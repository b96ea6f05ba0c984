#pragma once
#include <algorithm>
#include <span>
#include <string_view>

/// Finding things by the names that people type.
namespace sinew {

/// Another name for something.
struct Alias {
    std::string_view alias;
    std::string_view name;
};

constexpr char to_lower(char c)
{
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// Equal but for the case of ASCII letters.
constexpr bool same_name(std::string_view a, std::string_view b)
{
    return std::ranges::equal(a, b, [](char x, char y) { return to_lower(x) == to_lower(y); });
}

/// The one of `all` with this name or alias; nullptr: none.
template <class T>
const T* find_by_name(std::span<const T> all, std::span<const Alias> aliases, std::string_view name)
{
    for (const Alias& other : aliases)
        if (same_name(other.alias, name))
            name = other.name;
    for (const T& one : all)
        if (same_name(one.name, name))
            return &one;
    return nullptr;
}

} // namespace sinew
