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
    FlashFile file{.path = std::move(path)};
    const auto document = parse_document(text, file.path);
    if (!document)
        return std::unexpected(document.error());
    Reader reader{file.path};
    check_version(reader, *document, owner);
    reader.only(*document, owner, file_keys);
    file.joints = read_named<FlashJoint>(reader, *document, "joint", read_joint);
    if (reader.failed())
        return std::unexpected(reader.take_error());
    return file;
}

std::expected<FlashFile, Error> read_flash_file(const std::filesystem::path& path)
{
    const auto text = read_text(path, owner);
    if (!text)
        return std::unexpected(text.error());
    return parse_flash_file(*text, path.string());
}

} // namespace sinew::config
