#pragma once
#include "sinew/config/robot_file.hpp"

#include <initializer_list>
#include <span>
#include <toml++/toml.h>

/// Reads the values of a TOML document and remembers the first thing that is wrong with it. Only `robot_file.cpp` uses
/// it: no other file sees toml++.
namespace sinew::config {

/// A key as it stands in the document, or nothing.
struct Entry {
    const toml::key* key = nullptr;
    const toml::node* node = nullptr;
};

Mark mark_of(const toml::source_region& region);

/// After the first failure every call returns nothing and changes nothing, so a caller may read on and ask once.
class Reader
{
public:
    explicit Reader(const RobotFile& file) : file_(file) {}

    bool failed() const { return error_.has_value(); }
    Error take_error() { return std::move(*error_); }
    void fail(Mark at, std::string what);

    /// Fails for the first key of `table` that is not among `keys`; `owner` says whose keys they are.
    void only(const toml::table& table, std::string_view owner, std::span<const std::string_view> keys);

    // Each fails when the key is there with another type.
    std::optional<Marked<std::string>> text(const toml::table& table, std::string_view key);
    std::optional<Marked<std::int64_t>> whole(const toml::table& table, std::string_view key);
    std::optional<Marked<double>> real(const toml::table& table, std::string_view key); ///< finite
    const toml::table* section(const toml::table& table, std::string_view key);

    /// A quantity in SI as `key` + "_rad…" or in degrees as `key` + "_deg…"; fails when both are given.
    std::optional<Marked<double>> angle(const toml::table& table, std::string_view radians, std::string_view degrees);

    /// All keys of a table as they stand; fails for lists, tables and dates.
    std::vector<Setting> settings(const toml::table* table, std::string_view except = {});
    /// The tables of `[[…KEY]]`, each as its settings.
    std::vector<Section> sections(const toml::table& table, std::string_view key);

private:
    Entry find(const toml::table& table, std::string_view key) const;

    const RobotFile& file_;
    std::optional<Error> error_;
};

} // namespace sinew::config
