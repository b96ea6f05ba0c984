#include "apps/cli/command_line.hpp"

int main(int argc, char** argv)
{
    return sinew::cli::run(argc, argv);
}
