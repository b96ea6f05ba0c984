#pragma once
#include "apps/cli/device.hpp"
#include "sinew/family/sam/motion_text.hpp"

/// The self-running programs of SAM servos, for the verbs `motion …`.
namespace sinew::cli {

/// A program from a file of instructions; `-` is stdin. `bad_file` with the line.
std::expected<std::vector<wire::Pair>, Error> read_motion(const std::string& path);

/// The bytes of a program from words in hex.
std::expected<std::vector<wire::Pair>, Error> motion_from_hex(std::span<const std::string> words);

/// "10 52 31 0A"
std::string motion_bytes(std::span<const wire::Pair> program);

/// The request that stores a program; none switches it off. `unsupported` for other families.
std::expected<wire::Request, Error> motion_request(const Device& device, std::span<const wire::Pair> program);

} // namespace sinew::cli
