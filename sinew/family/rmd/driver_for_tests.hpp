#pragma once
#include "sinew/base/units.hpp"
#include "sinew/family/rmd/driver.hpp"
#include "sinew/family/rmd/lines.hpp"

#include <algorithm>
#include <gtest/gtest.h>

/// What the tests of the driver share: motors of id 1, and what they say.
namespace sinew::rmd::test {

using actuator::Mode;

inline Spec spec(std::string_view model = "MG", bool confirmed = true)
{
    Profile profile = profiles().front();
    profile.max_speed_confirmed = confirmed;
    return make_spec(*find_model(model), profile, 1);
}

inline wire::Frame frame(std::array<std::uint8_t, 8> data)
{
    wire::Frame out{.can_id = 0x141, .size = 8};
    std::ranges::copy(data, out.data.begin());
    return out;
}

inline Spec on_line(std::string_view name, std::string_view model = "MG")
{
    for (const auto& profile : profiles())
        if (profile.line.name == name)
            return make_spec(*find_model(model), profile, 1);
    ADD_FAILURE() << name;
    return spec();
}

inline TimePoint ms(int count)
{
    return TimePoint{} + std::chrono::milliseconds(count);
}

} // namespace sinew::rmd::test
