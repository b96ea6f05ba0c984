#include "tests/support/random.hpp"

#include <cstdio>
#include <gtest/gtest.h>

int main(int argc, char** argv)
{
    testing::InitGoogleTest(&argc, argv);
    std::printf("SINEW_SEED=%llu SINEW_CASES=%llu\n", static_cast<unsigned long long>(sinew::test::seed()),
                static_cast<unsigned long long>(sinew::test::cases()));
    return RUN_ALL_TESTS();
}
