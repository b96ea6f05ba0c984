#pragma once

namespace sinew::cli {

/// The whole command: understands the words, runs the verb, says what went wrong on stderr and returns the exit code.
int run(int argc, char** argv);

} // namespace sinew::cli
