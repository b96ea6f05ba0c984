#include "sinew/record/json.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace sinew::record {
namespace {

constexpr std::string_view blanks = " \t\r\n";
constexpr std::string_view digits = "0123456789ABCDEF";
constexpr std::string_view replacement = "\xEF\xBF\xBD";

/// How many bytes the character at the front has; 0: it is no UTF-8.
std::size_t character_size(std::string_view text)
{
    const auto byte = static_cast<unsigned char>(text[0]);
    const std::size_t size = byte < 0x80   ? 1
                             : byte < 0xC2 ? 0
                             : byte < 0xE0 ? 2
                             : byte < 0xF0 ? 3
                             : byte < 0xF5 ? 4
                                           : 0;
    if (size > text.size())
        return 0;
    std::uint32_t code = size < 2 ? byte : byte & (0x7FU >> size);
    for (std::size_t i = 1; i < size; ++i) {
        const auto next = static_cast<unsigned char>(text[i]);
        if ((next & 0xC0U) != 0x80U)
            return 0;
        code = code << 6U | (next & 0x3FU);
    }
    const bool too_long = (size == 3 && code < 0x800) || (size == 4 && code < 0x1'0000);
    const bool no_character = (code >= 0xD800 && code < 0xE000) || code > 0x10'FFFF;
    return too_long || no_character ? 0 : size;
}

void put_utf8(std::string& out, std::uint32_t code)
{
    if (code < 0x80) {
        out += static_cast<char>(code);
        return;
    }
    const int more = code < 0x800 ? 1 : code < 0x1'0000 ? 2 : 3;
    out += static_cast<char>((0xF0U << (3 - more) & 0xFFU) | code >> (6 * more));
    for (int i = more; i-- > 0;)
        out += static_cast<char>(0x80U | (code >> (6 * i) & 0x3FU));
}

/// Reads from the front of a text; once something is wrong nothing more is taken.
class Parser
{
public:
    explicit Parser(std::string_view text) : rest_(text) {}

    bool good() const { return good_; }
    bool at_end()
    {
        skip_blanks();
        return rest_.empty();
    }
    bool take(char c)
    {
        skip_blanks();
        if (!good_ || !rest_.starts_with(c))
            return false;
        rest_.remove_prefix(1);
        return true;
    }
    void expect(char c) { good_ = take(c) && good_; }
    bool take(std::string_view word)
    {
        if (!rest_.starts_with(word))
            return false;
        rest_.remove_prefix(word.size());
        return true;
    }
    char peek() const { return rest_.empty() ? '\0' : rest_[0]; } ///< without blanks, after `at_end`
    std::string string();
    double number();
    /// A list or an object, whatever is in it.
    void pass_over();

private:
    void skip_blanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(blanks), rest_.size())); }
    void escape(std::string& out);
    std::uint32_t four_digits();

    std::string_view rest_;
    bool good_ = true;
};

std::uint32_t Parser::four_digits()
{
    std::uint32_t value = 0;
    const auto part = rest_.substr(0, 4);
    const auto [end, problem] = std::from_chars(part.data(), part.data() + part.size(), value, 16);
    good_ = good_ && part.size() == 4 && problem == std::errc{} && end == part.data() + part.size();
    rest_.remove_prefix(part.size());
    return value;
}

void Parser::escape(std::string& out)
{
    if (rest_.empty()) {
        good_ = false;
        return;
    }
    const char c = rest_[0];
    rest_.remove_prefix(1);
    constexpr std::string_view names = "\"\\/bfnrt", means = "\"\\/\b\f\n\r\t";
    if (const auto at = names.find(c); at != std::string_view::npos) {
        out += means[at];
        return;
    }
    if (c != 'u') {
        good_ = false;
        return;
    }
    std::uint32_t code = four_digits();
    if (code >= 0xD800 && code < 0xDC00 && rest_.starts_with("\\u")) {
        rest_.remove_prefix(2);
        const std::uint32_t low = four_digits();
        code = low >= 0xDC00 && low < 0xE000 ? 0x1'0000 + ((code - 0xD800) << 10U) + (low - 0xDC00) : 0xFFFD;
    }
    put_utf8(out, code >= 0xD800 && code < 0xE000 ? 0xFFFD : code);
}

std::string Parser::string()
{
    std::string out;
    expect('"');
    while (good_) {
        const auto end = rest_.find_first_of("\"\\");
        if (end == std::string_view::npos) {
            good_ = false;
            break;
        }
        const auto plain = rest_.substr(0, end);
        good_ = std::ranges::none_of(plain, [](unsigned char c) { return c < ' '; });
        out += plain;
        const bool ends = rest_[end] == '"';
        rest_.remove_prefix(end + 1);
        if (ends)
            break;
        escape(out);
    }
    return out;
}

double Parser::number()
{
    double value = 0.0;
    const auto [end, problem] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    const bool is_number = problem == std::errc{} && std::isfinite(value);
    good_ = good_ && is_number;
    if (is_number)
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
}

void Parser::pass_over()
{
    std::size_t depth = 0;
    do {
        skip_blanks();
        if (rest_.empty()) {
            good_ = false;
        } else if (rest_[0] == '"') {
            string();
        } else {
            depth += rest_[0] == '{' || rest_[0] == '[';
            depth -= rest_[0] == '}' || rest_[0] == ']';
            rest_.remove_prefix(1);
        }
    } while (good_ && depth > 0);
}

} // namespace

void JsonWriter::key(std::string_view name)
{
    if (!std::exchange(first_, false))
        out_ += ',';
    out_ += '"';
    out_ += name; // ours: nothing in it has to be escaped
    out_ += "\":";
}

void JsonWriter::number(std::string_view name, double value)
{
    if (!std::isfinite(value))
        return;
    key(name);
    std::array<char, 32> text;
    const auto [end, problem] = std::to_chars(text.data(), text.data() + text.size(), value + 0.0); // no -0
    out_.append(text.data(), end);
}

void JsonWriter::whole(std::string_view name, std::int64_t value)
{
    key(name);
    std::array<char, 32> text;
    const auto [end, problem] = std::to_chars(text.data(), text.data() + text.size(), value);
    out_.append(text.data(), end);
}

void JsonWriter::flag(std::string_view name, bool value)
{
    key(name);
    out_ += value ? "true" : "false";
}

void JsonWriter::text(std::string_view name, std::string_view value)
{
    key(name);
    out_ += '"';
    while (!value.empty()) {
        const auto c = static_cast<unsigned char>(value[0]);
        const std::size_t size = character_size(value);
        if (c == '"' || c == '\\') {
            out_ += '\\';
            out_ += static_cast<char>(c);
        } else if (c < ' ') {
            out_ += "\\u00";
            out_ += digits[c >> 4U];
            out_ += digits[c & 0xFU];
        } else {
            out_ += size == 0 ? replacement : value.substr(0, size);
        }
        value.remove_prefix(std::max<std::size_t>(size, 1));
    }
    out_ += '"';
}

void JsonWriter::hex(std::string_view name, std::span<const std::uint8_t> bytes)
{
    key(name);
    out_ += '"';
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        if (i != 0)
            out_ += ' ';
        out_ += digits[bytes[i] >> 4U];
        out_ += digits[bytes[i] & 0xFU];
    }
    out_ += '"';
}

std::expected<JsonFields, Error> JsonFields::parse(std::string_view text)
{
    JsonFields out;
    Parser in(text);
    in.expect('{');
    for (bool first = true; in.good() && !in.take('}'); first = false) {
        if (!first)
            in.expect(',');
        auto key = in.string();
        in.expect(':');
        if (in.at_end() || !in.good())
            return fail(Errc::bad_file, "a message that is no JSON object");
        if (in.take("true"))
            out.all_.emplace_back(std::move(key), true);
        else if (in.take("false"))
            out.all_.emplace_back(std::move(key), false);
        else if (in.take("null"))
            continue;
        else if (in.peek() == '"')
            out.all_.emplace_back(std::move(key), in.string());
        else if (in.peek() == '{' || in.peek() == '[')
            in.pass_over();
        else
            out.all_.emplace_back(std::move(key), in.number());
    }
    if (!in.good() || !in.at_end())
        return fail(Errc::bad_file, "a message that is no JSON object");
    return out;
}

const JsonFields::Value* JsonFields::find(std::string_view key) const
{
    for (const auto& [name, value] : all_)
        if (name == key)
            return &value;
    return nullptr;
}

std::optional<double> JsonFields::number(std::string_view key) const
{
    const auto* value = find(key);
    const auto* number = value != nullptr ? std::get_if<double>(value) : nullptr;
    return number != nullptr ? std::optional(*number) : std::nullopt;
}

std::optional<bool> JsonFields::flag(std::string_view key) const
{
    const auto* value = find(key);
    const auto* flag = value != nullptr ? std::get_if<bool>(value) : nullptr;
    return flag != nullptr ? std::optional(*flag) : std::nullopt;
}

const std::string* JsonFields::text(std::string_view key) const
{
    const auto* value = find(key);
    return value != nullptr ? std::get_if<std::string>(value) : nullptr;
}

} // namespace sinew::record
