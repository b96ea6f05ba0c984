#pragma once
#include "sinew/config/robot_file.hpp"

#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

/// Named options of profiles and simulated devices as tables: key, what may be written, and how it gets into its
/// struct.
namespace sinew {

using OptionValue = decltype(config::Setting::value);

/// One key. `set` returns false when the value is not what `says` asks for.
template <class Target>
struct Option {
    std::string_view key;
    std::string_view says;
    bool (*set)(Target&, const OptionValue&);
};

/// A word of the file and what it means.
template <class T>
struct Word {
    std::string_view word;
    T value;
};

/// A number whether or not it was written with a point; nothing for the other kinds.
inline std::optional<double> as_number(const OptionValue& value)
{
    if (const auto* whole = std::get_if<std::int64_t>(&value))
        return static_cast<double>(*whole);
    if (const auto* real = std::get_if<double>(&value); real && std::isfinite(*real))
        return *real;
    return {};
}

template <auto Member>
struct MemberOf;
template <class T, class V, V T::* Member>
struct MemberOf<Member> {
    using Target = T;
    using Value = V;
};
template <auto Member>
using TargetOf = typename MemberOf<Member>::Target;

/// true or false.
template <auto Member>
consteval Option<TargetOf<Member>> flag(std::string_view key)
{
    return {key, "true or false", [](TargetOf<Member>& target, const OptionValue& value) {
                const auto* on = std::get_if<bool>(&value);
                if (on)
                    target.*Member = *on;
                return on != nullptr;
            }};
}

/// A whole number from `Low` to `High`.
template <auto Member, std::int64_t Low, std::int64_t High>
consteval Option<TargetOf<Member>> whole(std::string_view key, std::string_view says)
{
    return {key, says, [](TargetOf<Member>& target, const OptionValue& value) {
                const auto* number = std::get_if<std::int64_t>(&value);
                const bool good = number && Low <= *number && *number <= High;
                if (good)
                    target.*Member = static_cast<typename MemberOf<Member>::Value>(*number);
                return good;
            }};
}

/// A number from `Low` to `High`.
template <auto Member, double Low, double High>
consteval Option<TargetOf<Member>> number(std::string_view key, std::string_view says)
{
    return {key, says, [](TargetOf<Member>& target, const OptionValue& value) {
                const auto given = as_number(value);
                const bool good = given && Low <= *given && *given <= High;
                if (good)
                    target.*Member = *given;
                return good;
            }};
}

/// One of a few words.
template <auto Member, const auto& Words>
consteval Option<TargetOf<Member>> choice(std::string_view key, std::string_view says)
{
    return {key, says, [](TargetOf<Member>& target, const OptionValue& value) {
                const auto* given = std::get_if<std::string>(&value);
                for (const auto& word : Words)
                    if (given && *given == word.word) {
                        target.*Member = word.value;
                        return true;
                    }
                return false;
            }};
}

} // namespace sinew
