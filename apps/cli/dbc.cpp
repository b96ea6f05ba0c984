#include "apps/cli/formats.hpp"
#include "apps/cli/present.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using wire::Coding;
using wire::Field;
using wire::Kind;
using wire::MessageInfo;
using wire::Side;

constexpr std::size_t data_bytes = 8;

std::string identifier(std::string_view text)
{
    std::string out(text);
    std::ranges::replace(out, '-', '_');
    return out;
}

bool has_values(const Side& side)
{
    return std::ranges::any_of(side.fields, [](const Field& f) { return f.kind == Kind::value; });
}

/// One message of the file: what travels with one identifier.
class Block
{
public:
    Block(std::uint32_t can_id, std::string name) : can_id_(can_id), name_(std::move(name)) {}

    void add(const MessageInfo& message, const Side& side, const wire::Profile& line)
    {
        for (const auto& field : side.fields) {
            if (field.kind == Kind::opcode && commands_.empty())
                commands_ = fmt::format(" SG_ command M : {}|8@1+ (1,0) [0|255] \"\" Vector__XXX\n", 8 * field.byte);
            if (field.kind == Kind::value && field.when.holds(line.options))
                add(message, side, field, line);
        }
        if (side.opcode >= 0)
            values_ += fmt::format(" {} \"{}\"", side.opcode, message.name());
    }
    std::string text() const
    {
        return fmt::format("BO_ {} {}: {} Vector__XXX\n{}{}\n", can_id_, name_, data_bytes, commands_, signals_);
    }
    std::string values() const
    {
        return (values_.empty() ? std::string{} : fmt::format("VAL_ {} command{} ;\n", can_id_, values_)) + labels_;
    }

private:
    void add(const MessageInfo& message, const Side& side, const Field& field, const wire::Profile& line)
    {
        const auto reading = wire::reading(message, field, line.overrides);
        const bool bits = field.coding == Coding::bits;
        const int start = 8 * field.byte + (bits ? field.lsb : 0);
        const int size = bits ? field.msb - field.lsb + 1 : 8 * field.bytes;
        const bool scaled = reading.scale != wire::by_model && !field.unit.empty();
        const double scale = scaled ? reading.scale : 1.0, offset = scaled ? reading.offset : 0.0;
        const auto name = fmt::format("{}_{}", identifier(message.name()), identifier(field.name));
        signals_ += fmt::format(" SG_ {}{} : {}|{}@1{} ({},{}) [{}|{}] \"{}\" Vector__XXX\n", name,
                                side.opcode >= 0 ? fmt::format(" m{}", side.opcode) : "", start, size,
                                field.coding == Coding::i_le ? '-' : '+', scale, offset,
                                static_cast<double>(reading.range.low) * scale + offset,
                                static_cast<double>(reading.range.high) * scale + offset, scaled ? field.unit : "");
        if (field.labels.empty() || are_flags(field.labels))
            return;
        labels_ += fmt::format("VAL_ {} {}", can_id_, name);
        for (const auto& label : field.labels)
            labels_ += fmt::format(" {} \"{}\"", label.value, label.name);
        labels_ += " ;\n";
    }

    std::uint32_t can_id_;
    std::string name_, commands_, signals_, values_, labels_;
};

} // namespace

std::string dbc_file(const Family& family, const wire::Profile& line)
{
    std::vector<Block> blocks;
    const std::uint32_t reply_base = line.options.can_reply_base;
    for (auto id = family.ids.low; id <= family.ids.high; ++id) {
        std::optional<Block> requests, replies;
        const auto name = [&](std::string_view what) { return fmt::format("{}_{}{}", family.name, id, what); };
        for (const auto* message : line.messages) {
            const auto& layout = *message->request.layout;
            if (layout.can_fixed)
                continue;
            const auto can_id = static_cast<std::uint32_t>(layout.can_base + id);
            if (!requests)
                requests.emplace(can_id, name(reply_base != 0 ? "_request" : ""));
            if (reply_base != 0 && !replies)
                replies.emplace(static_cast<std::uint32_t>(reply_base + id), name("_reply"));
            const bool answer_counts = reply_base == 0 && message->reply.exists() && has_values(message->reply);
            requests->add(*message, answer_counts ? message->reply : message->request, line);
            if (replies && message->reply.exists())
                replies->add(*message, message->reply, line);
        }
        for (auto* block : {&requests, &replies})
            if (*block)
                blocks.push_back(std::move(**block));
    }
    for (const auto* message : line.messages)
        if (message->request.layout->can_fixed) {
            blocks.emplace_back(message->request.layout->can_base, identifier(message->name()));
            blocks.back().add(*message, message->request, line);
        }
    std::string out = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_:\n\n";
    for (const auto& block : blocks)
        out += block.text();
    out += fmt::format(
        "CM_ \"{}, {}: {}{}\";\n", family.title, line.name,
        "made by sinew from its rows. A value whose scale depends on the model stands raw, and so does what a "
        "parameter is made of.",
        reply_base != 0 ? "" : " Requests and replies share identifiers: the signals are those of replies.");
    for (const auto& block : blocks)
        out += block.values();
    return out;
}

} // namespace sinew::cli
