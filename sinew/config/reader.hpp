#pragma once
#include "sinew/config/robot_file.hpp"
#include "sinew/config/text_file.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <initializer_list>
#include <span>
#include <toml++/toml.h>

/// Reads the values of a TOML document and remembers the first thing that is wrong with it. Only the files of this room
/// use it: no other sees toml++.
namespace sinew::config {

/// A key as it stands in the document, or nothing.
struct Entry {
    const toml::key* key = nullptr;
    const toml::node* node = nullptr;
};

Mark mark_of(const toml::source_region& region);

/// A `bad_file` error at a place of the file with this path.
std::unexpected<Error> fail_at(std::string_view path, Mark at, std::string what);

/// `bad_file` with the place where it is no TOML.
std::expected<toml::table, Error> parse_document(std::string_view text, const std::string& path);

/// After the first failure every call returns nothing and changes nothing, so a caller may read on and ask once.
class Reader
{
public:
    /// The path is for messages and must outlive the reader.
    explicit Reader(std::string_view path) : path_(path) {}

    bool failed() const { return error_.has_value(); }
    Error take_error() { return std::move(*error_); }
    void fail(Mark at, std::string what);

    /// Fails for the first key of `table` that is not among `keys`; `owner` says whose keys they are.
    void only(const toml::table& table, std::string_view owner, std::span<const std::string_view> keys);

    // Each fails when the key is there with another type.
    std::optional<Marked<std::string>> text(const toml::table& table, std::string_view key);
    std::optional<Marked<std::int64_t>> whole(const toml::table& table, std::string_view key);
    std::optional<Marked<double>> real(const toml::table& table, std::string_view key); ///< finite
    std::optional<Marked<bool>> flag(const toml::table& table, std::string_view key);
    /// A number that must be above 0.
    std::optional<double> positive(const toml::table& table, std::string_view key);
    const toml::table* section(const toml::table& table, std::string_view key);
    /// The elements of a list, each of them a table.
    std::vector<const toml::table*> tables(const toml::table& table, std::string_view key);

    /// A quantity in SI as `key` + "_rad…" or in degrees as `key` + "_deg…"; fails when both are given.
    std::optional<Marked<double>> angle(const toml::table& table, std::string_view radians, std::string_view degrees);

    /// All keys of a table as they stand; fails for lists, tables and dates.
    std::vector<Setting> settings(const toml::table* table, std::string_view except = {});
    /// The tables of `[[…KEY]]`, each as its settings.
    std::vector<Section> sections(const toml::table& table, std::string_view key);

private:
    Entry find(const toml::table& table, std::string_view key) const;

    std::string_view path_;
    std::optional<Error> error_;
};

/// The value if it is there; else fails because `owner` needs it.
template <class T>
Marked<T> needed(Reader& reader, const std::optional<Marked<T>>& value, Mark at, std::string_view owner,
                 std::string_view key)
{
    if (!value)
        reader.fail(at, fmt::format("{} needs {}.", owner, key));
    return value.value_or(Marked<T>{});
}

/// Fails unless the document begins with `version = 1`; `owner` is "a robot file".
void check_version(Reader& reader, const toml::table& document, std::string_view owner);

/// Names appear in links and on the command line.
bool is_name(std::string_view name);

/// The tables of `[KIND.NAME]` in the order of the file.
template <class T, class Read>
std::vector<T> read_named(Reader& reader, const toml::table& document, std::string_view kind, Read read)
{
    std::vector<T> all;
    const toml::table* group = reader.section(document, kind);
    if (!group)
        return all;
    for (const auto& [key, node] : *group) {
        const Mark at = mark_of(key.source());
        const toml::table* table = node.as_table();
        if (!table)
            reader.fail(at, fmt::format("{} must be a table: [{}.NAME].", key.str(), kind));
        else if (!is_name(key.str()))
            reader.fail(at, fmt::format("the name '{}' may only have letters, digits, - and _.", key.str()));
        else
            all.push_back(read(reader, *table, std::string{key.str()}, at));
    }
    std::ranges::sort(all, {}, [](const T& one) { return std::pair{one.at.line, one.at.column}; });
    return all;
}

/// A document of one kind: its version and keys are checked, and `fill` reads the rest into the file.
template <class File, class Fill>
std::expected<File, Error> parse_file(std::string_view text, std::string path, std::string_view owner,
                                      std::span<const std::string_view> keys, const Fill& fill)
{
    File file;
    file.path = std::move(path);
    const auto document = parse_document(text, file.path);
    if (!document)
        return std::unexpected(document.error());
    Reader reader{file.path};
    check_version(reader, *document, owner);
    reader.only(*document, owner, keys);
    fill(reader, *document, file);
    if (reader.failed())
        return std::unexpected(reader.take_error());
    return file;
}

/// The same of a file that is read first.
template <class File, class Parse>
std::expected<File, Error> read_file(const std::filesystem::path& path, std::string_view owner, const Parse& parse)
{
    const auto text = read_text(path, owner);
    return text ? parse(*text, path.string()) : std::expected<File, Error>(std::unexpected(text.error()));
}

} // namespace sinew::config
