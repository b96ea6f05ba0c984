#pragma once
#include "sinew/base/error.hpp"

#include <expected>
#include <filesystem>
#include <string>
#include <string_view>

namespace sinew::config {

/// The whole file, which is `what`: "a robot file". `bad_file` when it is not there or cannot be read.
std::expected<std::string, Error> read_text(const std::filesystem::path& path, std::string_view what);

} // namespace sinew::config
