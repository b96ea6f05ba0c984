#pragma once
#include "sinew/base/time.hpp"

#include <optional>

namespace sinew::actuator {

/// A value with the time at which it was measured, or nothing. Reads like a `std::optional`.
template <class T>
class Measured
{
public:
    constexpr Measured() = default;
    constexpr Measured(T value, TimePoint at = {}) : value_(value), at_(at) {}

    constexpr bool has_value() const { return value_.has_value(); }
    constexpr explicit operator bool() const { return value_.has_value(); }
    constexpr const T& operator*() const { return *value_; }
    constexpr const T* operator->() const { return &*value_; }
    constexpr T value_or(T otherwise) const { return value_.value_or(otherwise); }
    constexpr void reset() { *this = {}; }

    constexpr const std::optional<T>& optional() const { return value_; }
    constexpr operator const std::optional<T>&() const { return value_; }

    /// When it was measured; means nothing where nothing was.
    constexpr TimePoint at() const { return at_; }
    /// How long ago that was; nothing where nothing was measured.
    constexpr std::optional<Duration> age(TimePoint now) const
    {
        return value_ ? std::optional(now - at_) : std::nullopt;
    }

    friend constexpr bool operator==(const Measured&, const Measured&) = default;
    friend constexpr bool operator==(const Measured& measured, const T& value) { return measured.value_ == value; }

private:
    std::optional<T> value_;
    TimePoint at_{};
};

} // namespace sinew::actuator
