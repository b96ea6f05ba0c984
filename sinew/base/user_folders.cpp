#include "sinew/base/user_folders.hpp"

#include <cstdlib>
#include <fmt/format.h>
#include <unistd.h>

namespace sinew {

std::filesystem::path runtime_folder()
{
    const char* given = std::getenv("XDG_RUNTIME_DIR");
    return given != nullptr && *given != '\0' ? std::filesystem::path(given) / "sinew"
                                              : std::filesystem::path(fmt::format("/tmp/sinew-{}", ::getuid()));
}

} // namespace sinew
