#include "apps/cli/reference.hpp"

#include "apps/cli/present.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using wire::Coding;
using wire::Field;
using wire::Kind;

std::string_view to_word(Kind kind)
{
    switch (kind) {
    case Kind::value:
        return "value";
    case Kind::constant:
        return "constant";
    case Kind::reserved:
        return "reserved";
    case Kind::repeat:
        return "repeat";
    case Kind::sequence:
        return "sequence";
    case Kind::opcode:
        return "opcode";
    case Kind::size:
        return "size";
    case Kind::address:
        return "address";
    case Kind::checksum:
        return "checksum";
    }
    return "";
}

std::string_view to_word(Coding coding)
{
    switch (coding) {
    case Coding::bits:
        return "bits";
    case Coding::u_le:
        return "unsigned, little endian";
    case Coding::i_le:
        return "signed, little endian";
    case Coding::u_be:
        return "unsigned, big endian";
    case Coding::septets:
        return "7 bits a byte";
    case Coding::signed_septets:
        return "sign, then 7 bits a byte";
    }
    return "";
}

bool carries_value(const Field& field)
{
    return field.kind == Kind::value || field.kind == Kind::sequence;
}

int bits_of(const Field& field)
{
    switch (field.coding) {
    case Coding::bits:
        return field.msb - field.lsb + 1;
    case Coding::septets:
        return field.top_bits + 7 * (field.bytes - 1);
    case Coding::signed_septets:
        return 15;
    default:
        return 8 * field.bytes;
    }
}

std::optional<std::int64_t> fixed_of(const Field& field)
{
    const bool fixed = field.kind == Kind::constant || field.kind == Kind::opcode || field.kind == Kind::size;
    return fixed ? std::optional(field.fixed) : std::nullopt;
}

Json range_json(const wire::Range& range)
{
    return Json::array({range.low, range.high});
}

Json to_json(const wire::MessageInfo& message, const Field& field, const wire::Profile& line)
{
    const auto reading = wire::reading(message, field, line.overrides);
    Json out = Json::object({{"name", field.name}, {"kind", to_word(field.kind)}, {"byte", int{field.byte}}});
    out.set("bytes", int{field.bytes});
    if (field.coding == Coding::bits) {
        out.set("msb", int{field.msb});
        out.set("lsb", int{field.lsb});
    }
    out.set("bits", bits_of(field));
    out.set("coding", to_word(field.coding));
    if (const auto fixed = fixed_of(field))
        out.set("fixed", *fixed);
    if (field.kind == Kind::repeat)
        out.set("repeats_byte", int{field.source});
    if (!carries_value(field) && field.kind != Kind::address)
        return out;
    out.set("range", range_json(reading.range));
    if (field.recommended.given())
        out.set("recommended", range_json(field.recommended));
    if (!field.unit.empty()) {
        out.set("unit", field.unit);
        out.set("scale", reading.scale != 0.0 ? Json(reading.scale) : Json()); // null: the model says
        out.set("offset", reading.offset);
    }
    if (!field.labels.empty()) {
        Json labels = Json::array();
        for (const auto& label : field.labels)
            labels.add(Json::object({{"value", label.value}, {"name", label.name}}));
        out.set("labels", std::move(labels));
    }
    if (!field.says.empty())
        out.set("says", field.says);
    return out;
}

Json to_json(const wire::MessageInfo& message, const wire::Side& side, const wire::Profile& line)
{
    if (!side.exists())
        return {};
    Json fields = Json::array();
    for (const auto& field : side.fields)
        if (field.when.holds(line.options))
            fields.add(to_json(message, field, line));
    Json out = Json::object({{"layout", side.layout->name}, {"size", int{side.size}}});
    if (side.layout->can_base != 0)
        out.set("can_id", side.layout->can_fixed ? Json(side.layout->can_base)
                                                 : Json(fmt::format("{} + id", side.layout->can_base)));
    out.set("fields", std::move(fields));
    if (side.variants.empty())
        return out;
    Json variants = Json::array();
    for (const auto& variant : side.variants) {
        Json inner = Json::array();
        for (const auto& field : variant.fields)
            inner.add(to_json(message, field, line));
        variants.add(Json::object({{"selector", variant.selector}, {"name", variant.name}, {"fields", inner}}));
    }
    out.set("selected_by", side.selector);
    out.set("replaces", side.replaced);
    out.set("variants", std::move(variants));
    return out;
}

std::string place(const Field& field)
{
    if (field.from_end)
        return "last";
    if (field.kind == Kind::sequence)
        return fmt::format("{}…", field.byte);
    if (field.bytes > 1)
        return fmt::format("{}-{}", field.byte, field.byte + field.bytes - 1);
    if (field.coding == Coding::bits && (field.msb != 7 || field.lsb != 0))
        return field.msb == field.lsb ? fmt::format("{}.{}", field.byte, field.msb)
                                      : fmt::format("{}.{}-{}", field.byte, field.msb, field.lsb);
    return std::to_string(field.byte);
}

/// Range, unit, words and remark of a field, in one line.
std::string meaning(const wire::MessageInfo& message, const Field& field, const wire::Profile& line)
{
    if (const auto fixed = fixed_of(field))
        return fmt::format("always 0x{:02X}", *fixed);
    if (field.kind == Kind::repeat)
        return fmt::format("byte {} once more", field.source);
    if (field.kind == Kind::reserved)
        return "sent as 0, not looked at";
    if (field.kind == Kind::checksum)
        return "checksum";
    const auto reading = wire::reading(message, field, line.overrides);
    std::string out = fmt::format("{} … {}", reading.range.low, reading.range.high);
    if (field.recommended.given())
        out += fmt::format(" (send {} … {})", field.recommended.low, field.recommended.high);
    if (!field.unit.empty() && reading.scale == 0.0)
        out += fmt::format("; {}, scale by model", field.unit);
    else if (!field.unit.empty())
        out += fmt::format("; {} {} each{}", number(reading.scale), field.unit,
                           reading.offset != 0.0 ? fmt::format(", plus {}", number(reading.offset)) : "");
    std::string labels;
    for (const auto& label : field.labels)
        labels += fmt::format("{}{} {}", labels.empty() ? "; " : ", ", label.value, label.name);
    return out + labels + (field.says.empty() ? "" : fmt::format("; {}", field.says));
}

std::string table_of(const wire::MessageInfo& message, std::span<const Field> fields, const wire::Profile& line)
{
    Table table({"BYTE", "FIELD", "MEANING"});
    for (const auto& field : fields)
        if (field.when.holds(line.options))
            table.add({place(field), std::string(field.name), meaning(message, field, line)});
    return table.empty() ? std::string{} : table.text(2);
}

std::string text_of(const wire::MessageInfo& message, wire::Direction direction, const wire::Profile& line)
{
    const wire::Side& side = message.side(direction);
    const std::string_view title = direction == wire::Direction::request ? "Request" : "Reply";
    if (!side.exists())
        return fmt::format("{}: none\n", bold(title));
    const bool grows = std::ranges::any_of(side.fields, [](const Field& f) { return f.kind == Kind::sequence; });
    std::string can;
    if (side.layout->can_base != 0)
        can = fmt::format(", identifier 0x{:03X}{}", side.layout->can_base, side.layout->can_fixed ? "" : " + id");
    std::string out = fmt::format("{}: {}{} bytes ({}{})\n{}", bold(title), grows ? "at least " : "", side.size,
                                  side.layout->name, can, table_of(message, side.fields, line));
    for (const auto& variant : side.variants)
        out += fmt::format("  where {} is {} ({}), {} is\n{}", side.selector, variant.name, variant.selector,
                           side.replaced, table_of(message, variant.fields, line));
    return out;
}

/// What the message does to the device, in words.
std::string effect(const wire::Info& info)
{
    std::string out(cli::to_word(info.access));
    if (info.access == wire::Access::flash)
        out += ", wears out the memory";
    if (info.moves)
        out += ", can move the shaft or let it go";
    if (info.broadcast)
        out += ", can go to all devices";
    return out;
}

} // namespace

Json to_json(const Family& family, const wire::Profile& line, const wire::MessageInfo& message)
{
    const auto& info = message.info;
    const auto opcode = [](int code) { return code >= 0 ? Json(code) : Json(); };
    Json out = Json::object({{"name", info.name},
                             {"family", family.name},
                             {"profile", line.name},
                             {"opcode", opcode(info.opcode)},
                             {"reply_opcode", message.reply.exists() ? opcode(message.reply.opcode) : Json()},
                             {"access", cli::to_word(info.access)},
                             {"moves", info.moves},
                             {"broadcast", info.broadcast},
                             {"answered_as_command", info.answered_as_command},
                             {"restriction", info.restriction.empty() ? Json() : Json(info.restriction)},
                             {"source", info.manual},
                             {"errata", info.errata},
                             {"says", info.says}});
    const auto ids = wire::request_ids(message);
    out.set("ids", ids.low >= 0 ? range_json(ids) : Json());
    out.set("request", to_json(message, message.request, line));
    out.set("reply", to_json(message, message.reply, line));
    return out;
}

std::string reference_text(const Family& family, const wire::Profile& line, const wire::MessageInfo& message)
{
    const auto& info = message.info;
    std::string out =
        fmt::format("{}\n{}\n\n", bold(fmt::format("{} {}", family.name, info.name)), wrap(info.says, 0, columns()));
    Table facts({"", ""});
    if (info.opcode >= 0)
        facts.add({"opcode", fmt::format("0x{:02X} ({})", info.opcode, info.opcode)});
    if (message.reply.exists() && message.reply.opcode >= 0 && message.reply.opcode != info.opcode)
        facts.add({"reply",
                   fmt::format("0x{:02X}{}", message.reply.opcode,
                               message.reply.opcode_also >= 0 ? fmt::format(" or 0x{:02X}", message.reply.opcode_also)
                                                              : "")});
    facts.add({"access", effect(info)});
    if (!info.restriction.empty())
        facts.add({"only on", std::string(info.restriction)});
    facts.add({"source", fmt::format("{}{}{}", info.manual, info.errata.empty() ? "" : "; ", info.errata)});
    facts.add({"profile", std::string(line.name)});
    const auto table = facts.text();
    out += table.substr(table.find('\n') + 1); // without the empty head
    return out + '\n' + text_of(message, wire::Direction::request, line) + '\n' +
           text_of(message, wire::Direction::reply, line);
}

} // namespace sinew::cli
