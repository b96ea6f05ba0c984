#pragma once
#include <filesystem>

/// Where sinew keeps files of a user, by the XDG base directory specification.
namespace sinew {

/// Sockets of programs that run: `$XDG_RUNTIME_DIR/sinew`, else a folder of the user in /tmp. Not made by this.
std::filesystem::path runtime_folder();

} // namespace sinew
