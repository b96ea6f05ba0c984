#include "sinew/config/text_file.hpp"

#include <fmt/format.h>
#include <fstream>
#include <iterator>

namespace sinew::config {

std::expected<std::string, Error> read_text(const std::filesystem::path& path, std::string_view what)
{
    const std::string name = path.empty() ? "''" : path.string();
    std::error_code code;
    const auto status = std::filesystem::status(path, code);
    if (!std::filesystem::exists(status))
        return sinew::fail(Errc::bad_file, fmt::format("{}: there is no such file.", name));
    if (std::filesystem::is_directory(status))
        return sinew::fail(Errc::bad_file, fmt::format("{}: this is a folder, not {}.", name, what));
    std::ifstream stream{path, std::ios::binary};
    std::string text{std::istreambuf_iterator<char>{stream}, {}};
    if (!stream || stream.bad())
        return sinew::fail(Errc::bad_file, fmt::format("{}: it cannot be read; is reading permitted?", name));
    return text;
}

} // namespace sinew::config
