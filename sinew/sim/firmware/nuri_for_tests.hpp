#pragma once
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/nuri_device.hpp"

/// A simulated Nuri on its bench. For the tests of this room only.
namespace sinew::sim {

using NuriBench = Bench<NuriDevice>;

constexpr std::size_t rsa = 0;
constexpr std::size_t mc = 1;

inline nuri::Spec spec_of(std::size_t line = rsa)
{
    return {.model = nuri::find_model(line == rsa ? "RSA" : "MC"), .profile = nuri::profiles()[line], .id = 3};
}

} // namespace sinew::sim
