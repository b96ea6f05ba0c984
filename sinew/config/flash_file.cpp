#include "sinew/config/flash_file.hpp"

#include "sinew/config/reader.hpp"

namespace sinew::config {
namespace {

constexpr std::string_view owner = "a flash file";
constexpr std::string_view file_keys[] = {"version", "joint"};

FlashJoint read_joint(Reader& reader, const toml::table& table, std::string name, Mark at)
{
    FlashJoint joint{.name = std::move(name), .at = at};
    joint.family = needed(reader, reader.text(table, "family"), at, "joint " + joint.name, "family");
    joint.values = reader.settings(&table, "family");
    return joint;
}

} // namespace

std::unexpected<Error> fail_at(const FlashFile& file, Mark at, std::string what)
{
    return fail_at(std::string_view(file.path), at, std::move(what));
}

std::expected<FlashFile, Error> parse_flash_file(std::string_view text, std::string path)
{
    return parse_file<FlashFile>(text, std::move(path), owner, file_keys,
                                 [](Reader& reader, const toml::table& document, FlashFile& file) {
                                     file.joints = read_named<FlashJoint>(reader, document, "joint", read_joint);
                                 });
}

std::expected<FlashFile, Error> read_flash_file(const std::filesystem::path& path)
{
    return read_file<FlashFile>(path, owner, parse_flash_file);
}

} // namespace sinew::config
