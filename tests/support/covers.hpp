#pragma once
#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace sinew::test {

/// The test that runs proves this line of the behaviour of the devices, such as "A.2 4". A table in docs/ is made from
/// these calls, so the name stands in the source as one literal.
inline void covers(std::string_view line)
{
    ::testing::Test::RecordProperty("behaviour_" + std::string(line), "covered");
}

} // namespace sinew::test
