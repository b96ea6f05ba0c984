#include "sinew/config/reader.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/base/units.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::config {
namespace {

std::string_view kind_of(const toml::node& node)
{
    switch (node.type()) {
    case toml::node_type::table:
        return "a table";
    case toml::node_type::array:
        return "a list";
    case toml::node_type::string:
        return "a text";
    case toml::node_type::integer:
        return "a whole number";
    case toml::node_type::floating_point:
        return "a number";
    case toml::node_type::boolean:
        return "true or false";
    default:
        return "a date or time";
    }
}

} // namespace

Mark mark_of(const toml::source_region& region)
{
    return {region.begin.line, region.begin.column};
}

std::unexpected<Error> fail_at(std::string_view path, Mark at, std::string what)
{
    return sinew::fail(Errc::bad_file, fmt::format("{}:{}:{}: {}", path, at.line, at.column, what));
}

std::expected<toml::table, Error> parse_document(std::string_view text, const std::string& path)
{
    try {
        return toml::parse(text, path);
    } catch (const toml::parse_error& error) {
        return fail_at(path, mark_of(error.source()), fmt::format("{}.", error.description()));
    }
}

bool is_name(std::string_view name)
{
    return !name.empty() && std::ranges::all_of(name, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
}

void check_version(Reader& reader, const toml::table& document, std::string_view owner)
{
    const auto version = needed(reader, reader.whole(document, "version"), {1, 1}, owner, "version = 1");
    if (version.value != 1)
        reader.fail(version.at, fmt::format("version {} is not known; this sinew reads version 1.", version.value));
}

void Reader::fail(Mark at, std::string what)
{
    if (!error_)
        error_ = fail_at(path_, at, std::move(what)).error();
}

void Reader::only(const toml::table& table, std::string_view owner, std::span<const std::string_view> keys)
{
    const toml::key* first = nullptr; // in the file; the table is sorted by name
    for (const auto& [key, node] : table) {
        const bool known = std::ranges::find(keys, key.str()) != keys.end();
        if (!known && (!first || key.source().begin < first->source().begin))
            first = &key;
    }
    if (!first)
        return;
    const std::string near = did_you_mean(first->str(), keys);
    fail(mark_of(first->source()), fmt::format("{} has no key '{}'{}", owner, first->str(), near.empty() ? "." : near));
}

Entry Reader::find(const toml::table& table, std::string_view key) const
{
    if (failed())
        return {};
    const auto at = table.find(key);
    return at == table.end() ? Entry{} : Entry{&at->first, &at->second};
}

std::optional<Marked<std::string>> Reader::text(const toml::table& table, std::string_view key)
{
    const Entry entry = find(table, key);
    if (!entry.node)
        return {};
    if (const auto* value = entry.node->as_string())
        return Marked<std::string>{value->get(), mark_of(entry.node->source())};
    fail(mark_of(entry.node->source()), fmt::format("{} must be a text in quotes, not {}.", key, kind_of(*entry.node)));
    return {};
}

std::optional<Marked<std::int64_t>> Reader::whole(const toml::table& table, std::string_view key)
{
    const Entry entry = find(table, key);
    if (!entry.node)
        return {};
    if (const auto* value = entry.node->as_integer())
        return Marked<std::int64_t>{value->get(), mark_of(entry.node->source())};
    fail(mark_of(entry.node->source()), fmt::format("{} must be a whole number, not {}.", key, kind_of(*entry.node)));
    return {};
}

std::optional<Marked<double>> Reader::real(const toml::table& table, std::string_view key)
{
    const Entry entry = find(table, key);
    if (!entry.node)
        return {};
    const Mark at = mark_of(entry.node->source());
    const auto value = entry.node->is_number() ? entry.node->value<double>() : std::optional<double>{};
    if (value && std::isfinite(*value))
        return Marked<double>{*value, at};
    fail(at, value ? fmt::format("{} must be a finite number.", key)
                   : fmt::format("{} must be a number, not {}.", key, kind_of(*entry.node)));
    return {};
}

std::optional<Marked<bool>> Reader::flag(const toml::table& table, std::string_view key)
{
    const Entry entry = find(table, key);
    if (!entry.node)
        return {};
    if (const auto* value = entry.node->as_boolean())
        return Marked<bool>{value->get(), mark_of(entry.node->source())};
    fail(mark_of(entry.node->source()), fmt::format("{} must be true or false, not {}.", key, kind_of(*entry.node)));
    return {};
}

std::optional<double> Reader::positive(const toml::table& table, std::string_view key)
{
    const auto value = real(table, key);
    if (value && value->value <= 0.0)
        fail(value->at, fmt::format("{} must be above 0.", key));
    return value ? std::optional(value->value) : std::nullopt;
}

const toml::table* Reader::section(const toml::table& table, std::string_view key)
{
    const Entry entry = find(table, key);
    if (!entry.node)
        return nullptr;
    if (const auto* section = entry.node->as_table())
        return section;
    fail(mark_of(entry.key->source()), fmt::format("{} must be a table, not {}.", key, kind_of(*entry.node)));
    return nullptr;
}

std::vector<const toml::table*> Reader::tables(const toml::table& table, std::string_view key)
{
    std::vector<const toml::table*> all;
    const Entry entry = find(table, key);
    if (!entry.node)
        return all;
    const toml::array* list = entry.node->as_array();
    if (list == nullptr) {
        fail(mark_of(entry.node->source()), fmt::format("{} must be a list, not {}.", key, kind_of(*entry.node)));
        return all;
    }
    for (const auto& one : *list) {
        if (!one.is_table())
            fail(mark_of(one.source()), fmt::format("{} must be tables in braces, not {}.", key, kind_of(one)));
        all.push_back(one.as_table());
    }
    return failed() ? std::vector<const toml::table*>{} : all;
}

std::optional<Marked<double>> Reader::angle(const toml::table& table, std::string_view radians,
                                            std::string_view degrees)
{
    auto in_radians = real(table, radians);
    const auto in_degrees = real(table, degrees);
    if (in_radians && in_degrees)
        fail(in_degrees->at, fmt::format("{} is given already; keep {} or {}.", radians, radians, degrees));
    if (in_degrees)
        return Marked<double>{units::rad(in_degrees->value), in_degrees->at};
    return in_radians;
}

std::vector<Section> Reader::sections(const toml::table& table, std::string_view key)
{
    std::vector<Section> all;
    const Entry entry = find(table, key);
    if (!entry.node)
        return all;
    const toml::array* list = entry.node->as_array();
    if (list == nullptr || !list->is_array_of_tables()) {
        fail(mark_of(entry.key->source()), fmt::format("{} must be tables: write [[sim.{}]] above each.", key, key));
        return all;
    }
    for (const auto& one : *list)
        all.push_back({settings(one.as_table()), mark_of(one.source())});
    return all;
}

std::vector<Setting> Reader::settings(const toml::table* table, std::string_view except)
{
    std::vector<Setting> all;
    if (!table)
        return all;
    for (const auto& [key, node] : *table) {
        if (key.str() == except)
            continue;
        Setting setting{.key = std::string{key.str()}, .value = false, .at = mark_of(key.source())};
        if (const auto* text = node.as_string())
            setting.value = text->get();
        else if (const auto* whole = node.as_integer())
            setting.value = whole->get();
        else if (const auto* real = node.as_floating_point())
            setting.value = real->get();
        else if (const auto* on = node.as_boolean())
            setting.value = on->get();
        else
            fail(setting.at,
                 fmt::format("{} must be a number, a text or true or false, not {}.", setting.key, kind_of(node)));
        all.push_back(std::move(setting));
    }
    std::ranges::sort(all, {}, [](const Setting& one) { return std::pair{one.at.line, one.at.column}; });
    return all;
}

} // namespace sinew::config
