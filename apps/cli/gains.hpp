#pragma once
#include "apps/cli/device_settings.hpp"

#include <span>
#include <string>
#include <vector>

/// Gains of the position loop that are tried until power-off, for `tune`.
namespace sinew::cli {

class Gains
{
public:
    /// Whether the device has these gains, from words such as "p=30". `unsupported` where it stores them at once.
    static std::expected<void, Error> check(const Device& device, std::span<const std::string> words);
    /// Reads what the device has, and changes the named ones in it; nothing is set yet.
    static std::expected<Gains, Error> from(bus::Bus& bus, const Device& device, std::span<const std::string> words);

    /// Until power-off.
    std::expected<void, Error> set_trial(bus::Bus& bus, const Device& device) const;
    /// What was there before, until power-off.
    std::expected<void, Error> set_back(bus::Bus& bus, const Device& device) const;
    /// In flash. The error says what was stored before it, and what may be.
    std::expected<void, Error> store(bus::Bus& bus, const Device& device) const;

private:
    struct One {
        LineSetting setting;
        wire::Values before, now;
    };
    std::vector<One> all_;
};

} // namespace sinew::cli
