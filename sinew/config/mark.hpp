#pragma once
#include <cstdint>

namespace sinew::config {

/// Place of a value in its file, both counted from 1.
struct Mark {
    std::uint32_t line = 0;
    std::uint32_t column = 0;
};

template <class T>
struct Marked {
    T value{};
    Mark at{};
};

} // namespace sinew::config
