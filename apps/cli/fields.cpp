#include "apps/cli/fields.hpp"

#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

using wire::Field;
using wire::Kind;

struct Given {
    std::string_view name, value;
    bool used = false;
};

bool same_word(std::string_view a, std::string_view b)
{
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c == ' ' ? '-' : c; };
    return std::ranges::equal(a, b, {}, lower, lower);
}

std::expected<std::vector<Given>, Error> split(std::span<const std::string> words)
{
    std::vector<Given> out;
    for (const std::string_view word : words) {
        const auto equals = word.find('=');
        if (equals == std::string_view::npos || equals == 0 || equals + 1 == word.size())
            return fail(Errc::bad_argument, fmt::format("'{}' is not written FIELD=VALUE", word));
        const auto name = word.substr(0, equals);
        if (std::ranges::find(out, name, &Given::name) != out.end())
            return fail(Errc::bad_argument, fmt::format("{} is given twice", name));
        out.push_back({name, word.substr(equals + 1)});
    }
    return out;
}

/// What may be written for a field.
std::string what_fits(const Field& field, const wire::Reading& reading)
{
    std::vector<std::string_view> labels;
    for (const auto& label : field.labels)
        labels.push_back(label.name);
    if (!labels.empty())
        return fmt::format("{}", fmt::join(labels, ", "));
    return fmt::format("a whole number from {} to {}", reading.range.low, reading.range.high);
}

std::optional<std::int64_t> physical(std::string_view word, const Field& field, const wire::Reading& reading)
{
    const auto unit = field.unit.empty() && reading.scale != 1.0 ? std::string_view("deg") : field.unit;
    if (unit.empty() || reading.scale == 0.0 || !word.ends_with(unit))
        return std::nullopt;
    word.remove_suffix(unit.size());
    double value = 0.0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    const double raw = (value - reading.offset) / reading.scale;
    constexpr double most = 9e15; // whole numbers are exact below
    if (problem != std::errc{} || end != word.data() + word.size() || !(std::abs(raw) < most))
        return std::nullopt;
    return std::llround(raw);
}

std::expected<std::int64_t, Error> raw_of(const Device& device, const wire::MessageInfo& message, const Field& field,
                                          std::string_view word)
{
    const auto reading = device.reading(message, field);
    for (const auto& label : field.labels)
        if (same_word(label.name, word))
            return label.value;
    // Whole numbers first: 0x1A is no ampere.
    const auto whole = to_integer(word);
    const auto raw = whole ? std::optional(*whole) : physical(word, field, reading);
    if (!raw) {
        auto refused = fail(Errc::bad_argument, fmt::format("{} of {} takes {}, not '{}'", field.name, message.name(),
                                                            what_fits(field, reading), word));
        refused.error().field = field.name; // a model may know a unit for it
        return refused;
    }
    if (!reading.range.contains(*raw))
        return std::unexpected(Error{.code = Errc::out_of_range,
                                     .message = message.name(),
                                     .field = field.name,
                                     .value = *raw,
                                     .low = reading.range.low,
                                     .high = reading.range.high});
    return *raw;
}

std::expected<void, Error> add_sequence(const Device& device, const wire::MessageInfo& message, const Field& field,
                                        std::string_view words, wire::Values& out)
{
    std::size_t count = 0;
    constexpr std::size_t most = 16;
    while (!words.empty()) {
        const auto end = std::min(words.find(','), words.size());
        const auto raw = raw_of(device, message, field, words.substr(0, end));
        if (!raw)
            return std::unexpected(raw.error());
        if (++count > most)
            return fail(Errc::bad_argument, fmt::format("{} takes at most {} bytes", field.name, most));
        out.add(field, *raw);
        words.remove_prefix(std::min(end + 1, words.size()));
    }
    // The count is the field before the sequence.
    const auto announced = out.all().size() > count ? out.all()[out.all().size() - count - 1].raw : 0;
    if (std::cmp_not_equal(count, 2 * announced))
        return fail(Errc::bad_argument, fmt::format("{} has {} bytes; {} instructions take {}", field.name, count,
                                                    announced, 2 * announced));
    return {};
}

std::unexpected<Error> unknown_field(const wire::MessageInfo& message, std::string_view name,
                                     const wire::Values& fields)
{
    std::vector<std::string_view> names;
    for (const auto& value : fields)
        names.push_back(value.field->name);
    if (names.empty())
        return fail(Errc::unknown_name, fmt::format("{} has no fields, so '{}' means nothing", message.name(), name));
    return fail(Errc::unknown_name,
                fmt::format("{} has no field '{}'{}", message.name(), name, suggestion(name, names)));
}

} // namespace

std::expected<wire::Values, Error> values_from(const Device& device, const wire::MessageInfo& message,
                                               std::span<const std::string> words)
{
    auto given = split(words);
    if (!given)
        return std::unexpected(given.error());
    const auto find = [&](std::string_view name) {
        const auto found = std::ranges::find(*given, name, &Given::name);
        return found == given->end() ? nullptr : &*found;
    };
    const auto& side = message.request;
    std::optional<std::int64_t> selector;
    if (!side.selector.empty())
        for (const auto& field : side.fields)
            if (const auto* word = find(side.selector); word != nullptr && field.name == side.selector) {
                const auto raw = raw_of(device, message, field, word->value);
                if (!raw)
                    return std::unexpected(raw.error());
                selector = *raw;
            }
    const auto fields = wire::value_fields(side, device.options(), selector);
    wire::Values out;
    for (const auto& [field, unused] : fields) {
        Given* word = find(field->name);
        if (word != nullptr)
            word->used = true;
        if (field->kind == Kind::sequence) {
            if (auto added = add_sequence(device, message, *field, word != nullptr ? word->value : "", out); !added)
                return std::unexpected(added.error());
            continue;
        }
        if (word == nullptr)
            return fail(Errc::missing_field, fmt::format("{} needs {}=VALUE: {}", message.name(), field->name,
                                                         what_fits(*field, device.reading(message, *field))));
        const auto raw = raw_of(device, message, *field, word->value);
        if (!raw)
            return std::unexpected(raw.error());
        out.add(*field, *raw);
    }
    for (const auto& word : *given)
        if (!word.used)
            return unknown_field(message, word.name, fields);
    return out;
}

std::expected<wire::Request, Error> request_from(const Device& device, const wire::MessageInfo& message,
                                                 std::span<const std::string> words)
{
    const auto values = values_from(device, message, words);
    return values ? request(device, message, *values) : std::unexpected(values.error());
}

} // namespace sinew::cli
