#pragma once
#include "sinew/config/robot_file.hpp"

/// A recording of a robot can stand wherever a robot file does: it keeps that file, and its frames answer for the
/// devices.
namespace sinew::cli {

/// Whether this is a recording with a robot in it, by its first bytes.
bool is_recording(const std::string& path);

/// A robot file, or the one in a recording: its buses are then those of the recording (`replay:FILE#BUS`), and `path`
/// is that of the recording. `bad_file`.
std::expected<config::RobotFile, Error> robot_file_at(const std::string& path);

/// The text of a robot file, or of the one in a recording. `bad_file`.
std::expected<std::string, Error> robot_text_at(const std::string& path);

} // namespace sinew::cli
