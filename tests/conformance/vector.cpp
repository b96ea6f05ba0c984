#include "tests/conformance/vector.hpp"

#include "sinew/family/rmd/messages.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/wire/select.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace sinew::conformance {
namespace {

using namespace wire;

std::string lower(std::string_view text)
{
    std::string out(text);
    std::ranges::transform(out, out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return out;
}

std::uint32_t option_bit(const std::string& name)
{
    if (name == "clear_error_reply_9b")
        return rmd::clear_error_reply_9b;
    if (name == "quick_boundary_lower_first")
        return sam::quick_boundary_lower_first;
    throw std::runtime_error("no option " + name);
}

std::vector<const MessageInfo*> rows_of(const Vector& vector, const json& meaning)
{
    std::vector<const MessageInfo*> out;
    for (const auto* message : vector.family->manual.messages) {
        const Side& side = message->side(vector.direction);
        if (!side.exists())
            continue;
        bool same = false;
        if (vector.family->name == "sam") {
            same = with_dashes(meaning.at("command")) == message->name();
        } else if (vector.family->name == "nuri") {
            same = meaning.at("mode") == side.opcode;
        } else {
            const json& command = meaning.at("command");
            same = message->info.opcode == (command.is_null() ? -1 : command.get<int>());
        }
        if (same)
            out.push_back(message);
    }
    if (out.empty())
        throw std::runtime_error("no row for " + meaning.dump());
    return out;
}

/// The key of a field in a meaning: its name, alone or with its unit behind it.
bool names_field(const std::string& key, const Field& f)
{
    std::string unit = lower(f.unit);
    std::ranges::replace(unit, '/', '_');
    return key == f.name || (!unit.empty() && key == std::string(f.name) + "_" + unit) ||
           (key == "baud" && f.name == "baud_code");
}

std::int64_t raw_of(const Vector& vector, const Field& f, const std::string& key, const json& value)
{
    if (value.is_string() || key == "baud") {
        const std::string word = value.is_string() ? value.get<std::string>() : value.dump();
        for (const auto& label : f.labels)
            if (lower(label.name) == lower(word))
                return label.value;
        throw std::runtime_error("no label " + word + " in " + std::string(f.name));
    }
    const bool is_raw = vector.family->name == "sam" || f.scale == by_model;
    if (is_raw)
        return value.get<std::int64_t>();
    const double raw = (value.get<double>() - f.offset) / f.scale;
    if (std::abs(raw - std::round(raw)) > 1e-6)
        throw std::runtime_error(key + " is between two raw values");
    return std::llround(raw);
}

/// Instructions as they travel (A.14): number and sub-instruction in one byte, its data in the next.
void add_program(const json& program, const Field& f, Values& values)
{
    for (const auto& step : program) {
        const std::string op = step.at("op");
        if (op == "position") {
            values.add(f, 0x10 | step.at("speed").get<int>());
            values.add(f, step.at("position").get<int>());
        } else if (op == "delay") {
            values.add(f, 0x30 | step.at("ms").get<int>() >> 8);
            values.add(f, step.at("ms").get<int>() & 0xFF);
        } else {
            throw std::runtime_error("instruction " + op + " is not known here");
        }
    }
}

Meant to_meant(const Vector& vector, const json& meaning, Options options, const MessageInfo& message)
{
    const Side& side = message.side(vector.direction);
    const bool is_bare = side.layout == &sam::bare;
    Meant out{.message = &message};
    std::vector<std::string> open;
    for (const auto& [key, unused] : meaning.items())
        open.push_back(key);
    const auto take = [&](const std::string& key) { std::erase(open, key); };
    take("comment");
    if (vector.family->name != "sam")
        take("mode");
    take("command");
    if (!is_bare && meaning.contains("id")) {
        out.id = meaning.at("id");
        take("id");
    } else if (!is_bare && !side.layout->can_fixed) {
        out.id = static_cast<int>(to_frame(vector, json::array()).can_id - side.layout->can_base);
    }
    std::optional<std::int64_t> selector;
    if (!side.selector.empty())
        selector = meaning.at(std::string(side.selector)).get<std::int64_t>();
    for (const auto& [field, none] : value_fields(side, options, selector)) {
        if (field->kind == Kind::sequence) {
            add_program(meaning.at("program"), *field, out.values);
            take("program");
            continue;
        }
        const auto key = std::ranges::find_if(open, [&](const auto& k) { return names_field(k, *field); });
        if (key == open.end())
            throw std::runtime_error("the example says nothing about " + std::string(field->name));
        out.values.add(*field, raw_of(vector, *field, *key, meaning.at(*key)));
        open.erase(key);
    }
    for (const auto& f : side.fields)
        if (f.kind == Kind::repeat && meaning.contains(std::string(f.name))) {
            out.repeats.emplace_back(&f, meaning.at(std::string(f.name)).get<std::int64_t>());
            take(std::string(f.name));
        }
    if (!open.empty())
        throw std::runtime_error("no field for " + open.front());
    return out;
}

} // namespace

json read_data(const std::string& name)
{
    std::ifstream file(std::string(SINEW_CONFORMANCE_DATA) + "/" + name);
    return json::parse(file);
}

std::vector<Vector> read_vectors(const std::string& name)
{
    std::vector<Vector> out;
    for (auto& entry : read_data(name)) {
        Vector vector{.id = entry.at("id"),
                      .family = &test::family(entry.at("protocol").get<std::string>()),
                      .direction = entry.at("direction") == "reply" ? Direction::reply : Direction::request,
                      .erratum = entry.at("status") == "erratum"};
        for (const auto& option : entry.value("options", json::array()))
            vector.options.bits |= option_bit(option);
        vector.all = std::move(entry);
        out.push_back(std::move(vector));
    }
    return out;
}

std::string with_dashes(std::string name)
{
    std::ranges::replace(name, '_', '-');
    return name;
}

Frame to_frame(const Vector& vector, const json& bytes)
{
    Frame frame{.size = static_cast<std::uint8_t>(bytes.size())};
    std::ranges::copy(bytes.get<std::vector<std::uint8_t>>(), frame.data.begin());
    if (vector.family->name == "rmd") {
        const bool is_printed = vector.all.contains("can_id") && vector.all["can_id"].is_number();
        frame.can_id = is_printed ? vector.all["can_id"].get<std::uint32_t>() : rmd::identifier_base + 1;
    }
    return frame;
}

std::vector<Meant> to_meant(const Vector& vector, const json& meaning, Options options)
{
    std::vector<Meant> out;
    for (const auto* message : rows_of(vector, meaning))
        out.push_back(to_meant(vector, meaning, options, *message));
    return out;
}

} // namespace sinew::conformance
