#include "tests/property/sides.hpp"

#include <algorithm>

namespace sinew::property {

using namespace wire;

std::vector<NamedSide> all_sides()
{
    std::vector<NamedSide> out;
    for (const auto& family : test::families())
        for (const auto* message : family.manual.messages)
            for (const auto direction : {Direction::request, Direction::reply})
                if (message->side(direction).exists())
                    out.push_back({&family, message, direction});
    return out;
}

std::string test_name(const NamedSide& side)
{
    std::string name = std::string(side.family->name) + "_" + std::string(side.message->name());
    std::ranges::replace(name, '-', '_');
    return name + (side.direction == Direction::request ? "_request" : "_reply");
}

Range ids_of(const MessageInfo& message, Direction direction)
{
    const Side& side = message.side(direction);
    for (const auto& f : side.fields)
        if (f.kind == Kind::address)
            return allowed(f);
    const bool in_identifier = side.layout->can_base != 0 && !side.layout->can_fixed;
    return in_identifier ? side.layout->ids : Range{};
}

Sample sample(const MessageInfo& message, Direction direction, test::Random& random)
{
    const Side& side = message.side(direction);
    Sample out;
    for (const auto& f : side.fields)
        if (random.one_in(2))
            out.options.bits |= f.when.mask;
    if (side.opcode_also >= 0 && random.one_in(2))
        out.options.bits |= side.also_when;
    if (side.layout->can_base != 0 && random.one_in(4))
        out.options.can_reply_base = 0x240;
    if (const Range ids = ids_of(message, direction); ids.given())
        out.id = static_cast<int>(random.in(ids));
    std::optional<std::int64_t> selector;
    if (!side.variants.empty())
        selector = side.variants[random.below(side.variants.size())].selector;
    for (const auto& [field, unused] : value_fields(side, out.options, selector)) {
        if (field->kind == Kind::sequence) {
            const auto count = out.values.all().back().raw;
            for (std::int64_t i = 0; i < 2 * count; ++i)
                out.values.add(*field, random.in(field->range));
        } else {
            const bool selects = !side.selector.empty() && field->name == side.selector;
            out.values.add(*field, selects ? *selector : random.in(allowed(*field)));
        }
    }
    return out;
}

bool same_values(const Values& a, const Values& b)
{
    return std::ranges::equal(a.all(), b.all(),
                              [](const Value& x, const Value& y) { return x.field == y.field && x.raw == y.raw; });
}

Values with(const Values& values, std::size_t at, std::int64_t raw)
{
    Values out;
    for (std::size_t i = 0; i < values.all().size(); ++i)
        out.add(*values.all()[i].field, i == at ? raw : values.all()[i].raw);
    return out;
}

Values without(const Values& values, std::size_t at)
{
    Values out;
    for (std::size_t i = 0; i < values.all().size(); ++i)
        if (i != at)
            out.add(*values.all()[i].field, values.all()[i].raw);
    return out;
}

std::vector<std::size_t> narrow_values(const Values& values)
{
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < values.all().size(); ++i) {
        const Field& f = *values.all()[i].field;
        if (f.kind != Kind::sequence && allowed(f) != capacity(f))
            out.push_back(i);
    }
    return out;
}

void seal(const Side& side, Frame& frame)
{
    if (const int at = checksum_byte(*side.layout, frame.size); at >= 0)
        frame.data[static_cast<std::size_t>(at)] = checksum(side.layout->checksum, frame.data.data(), frame.size);
}

Frame with_raw(const MessageInfo& message, Direction direction, Frame frame, const Field& field, std::int64_t raw)
{
    const Side& side = message.side(direction);
    for (std::size_t byte = field.byte; byte < std::size_t{field.byte} + field.bytes; ++byte)
        frame.data[byte] = static_cast<std::uint8_t>(frame.data[byte] & ~claimed(field, byte));
    put(field, raw, frame.data.data());
    for (const auto& f : side.fields)
        if (f.kind == Kind::repeat)
            frame.data[f.byte] = frame.data[f.source];
    seal(side, frame);
    return frame;
}

bool names(const Error& error, const MessageInfo& message, const Field& field, std::int64_t value)
{
    const Range range = field.kind == Kind::sequence ? field.range : allowed(field);
    return error.code == Errc::out_of_range && error.message == message.name() && error.field == field.name &&
           error.value == value && error.low == range.low && error.high == range.high;
}

} // namespace sinew::property
