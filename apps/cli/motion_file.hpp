#pragma once
#include "apps/cli/device.hpp"
#include "sinew/family/sam/motion_text.hpp"

/// The self-running programs of SAM servos, for the verbs `motion …`.
namespace sinew::cli {

/// A program from a file of instructions; `-` is stdin. `bad_file` with the line.
std::expected<sam::Program, Error> read_motion(const std::string& path);

/// The bytes of a program from words in hex.
std::expected<std::vector<wire::Pair>, Error> motion_from_hex(std::span<const std::string> words);

/// "10 52 31 0A"
std::string motion_bytes(std::span<const wire::Pair> program);

/// The request that stores a program; none switches it off. `unsupported` for other families.
std::expected<wire::Request, Error> motion_request(const Device& device, std::span<const wire::Pair> program);

/// A servo that runs its program alone asks nobody: `out_of_range` with the line that would take the joint beyond its
/// limits.
std::expected<void, Error> check_motion(const Device& device, const sam::Program& program);

/// "4 instructions"
std::string instructions(std::size_t count);

} // namespace sinew::cli
