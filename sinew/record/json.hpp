#pragma once
#include "sinew/base/error.hpp"

#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// The JSON of recordings: objects of numbers, words and switches, one level deep.
namespace sinew::record {

/// Appends an object to a text, member by member; it is closed when this goes.
class JsonWriter
{
public:
    explicit JsonWriter(std::string& out) : out_(out) { out_ += '{'; }
    ~JsonWriter() { out_ += '}'; }
    JsonWriter(const JsonWriter&) = delete;
    JsonWriter& operator=(const JsonWriter&) = delete;

    /// The shortest digits that give the same number again; nothing where it is not finite.
    void number(std::string_view key, double value);
    void whole(std::string_view key, std::int64_t value);
    void flag(std::string_view key, bool value);
    /// Bytes that are no UTF-8 become U+FFFD.
    void text(std::string_view key, std::string_view value);
    /// "FF E0".
    void hex(std::string_view key, std::span<const std::uint8_t> bytes);

private:
    void key(std::string_view name);

    std::string& out_;
    bool first_ = true;
};

/// The members of an object. What is null, a list or an object itself is not among them.
class JsonFields
{
public:
    /// `bad_file` where it is no JSON object.
    static std::expected<JsonFields, Error> parse(std::string_view text);

    std::optional<double> number(std::string_view key) const;
    std::optional<bool> flag(std::string_view key) const;
    const std::string* text(std::string_view key) const; ///< nullptr: not there

private:
    using Value = std::variant<double, bool, std::string>;
    const Value* find(std::string_view key) const;

    std::vector<std::pair<std::string, Value>> all_;
};

} // namespace sinew::record
