#include "tests/bus/matching.hpp"

int main(int argc, char** argv)
{
    testing::InitGoogleTest(&argc, argv);
    fmt::print("SINEW_SEED={} SINEW_EXCHANGES={}\n", sinew::test::seed(), sinew::tests::exchanges());
    return RUN_ALL_TESTS();
}
