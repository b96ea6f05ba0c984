#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace sinew::diagnosis {

enum class Severity : std::uint8_t {
    ok,
    note,    ///< worth knowing; nothing is wrong
    warning, ///< works, but not as well as it could, or not for long
    error,   ///< does not work, or not as the robot file says
};

std::string_view to_word(Severity severity);

/// What a finding can be. The names stay: programs and pages go by them.
struct Kind {
    std::string_view name;  ///< "wrong-baud"
    std::string_view check; ///< that finds it, "bit-rate"
    Severity severity{};
    std::string_view meaning; ///< one sentence
    std::string_view next;    ///< what to try, where nothing better is known
};

std::span<const Kind> kinds();
/// The kind must exist.
const Kind& kind(std::string_view name);

/// One thing that was found, with where, why, what it means and what to try next. What is in order is a finding of
/// severity `ok`, named after its check.
struct Finding {
    std::string_view name;
    std::string_view check;
    Severity severity = Severity::ok;
    std::string bus;   ///< of the robot file; empty: none
    std::string link;  ///< that was looked at
    int id = -1;       ///< -1: not about one device
    std::string joint; ///< of the robot file; empty: none
    std::string evidence;
    std::string_view meaning; ///< empty where all is well
    std::string next;
};

Severity worst(std::span<const Finding> findings);

} // namespace sinew::diagnosis
