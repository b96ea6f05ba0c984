#include "sinew/wire/values.hpp"

#include "sinew/wire/codec.hpp"

#include <algorithm>

namespace sinew::wire {
namespace {

bool carries_meaning(const Field& f, Options options)
{
    return (f.kind == Kind::value || f.kind == Kind::sequence) && f.when.holds(options);
}

const Variant* variant_of(const Side& side, std::optional<std::int64_t> selector)
{
    for (const auto& variant : side.variants)
        if (selector == variant.selector)
            return &variant;
    return nullptr;
}

const Field* field_of_kind(const Side& side, Kind kind)
{
    for (const auto& f : side.fields)
        if (f.kind == kind)
            return &f;
    return nullptr;
}

Error wrong(Errc code, const Info& info, std::string_view field, std::int64_t value, std::int64_t expected)
{
    return {.code = code, .message = info.name, .field = field, .value = value, .low = expected};
}

int address_of(const Side& side, const Frame& frame, Options options, Direction direction)
{
    const Layout& layout = *side.layout;
    if (layout.can_base != 0 && !layout.can_fixed) {
        const bool other = direction == Direction::reply && options.can_reply_base != 0;
        return static_cast<int>(frame.can_id - (other ? options.can_reply_base : layout.can_base));
    }
    std::int64_t id = -1;
    if (const auto* f = field_of_kind(side, Kind::address))
        get(*f, frame.data.data(), id);
    return static_cast<int>(id);
}

Range ids_of(const Side& side)
{
    const auto* f = field_of_kind(side, Kind::address);
    return f ? allowed(*f) : side.layout->ids;
}

bool has_id(const Side& side)
{
    return field_of_kind(side, Kind::address) || (side.layout->can_base != 0 && !side.layout->can_fixed);
}

std::optional<Error> check_framing(const Info& info, const Side& side, const Frame& frame)
{
    const Layout& layout = *side.layout;
    for (const auto& f : side.fields) {
        const std::uint8_t byte = frame.data[f.byte];
        if (f.kind == Kind::opcode && byte != f.fixed && byte != side.opcode_also)
            return wrong(Errc::bad_constant, info, f.name, byte, f.fixed);
        if (f.kind == Kind::constant || f.kind == Kind::size) {
            std::int64_t value{};
            if (!get(f, frame.data.data(), value) || value != f.fixed)
                return wrong(Errc::bad_constant, info, f.name, value, f.fixed);
        }
    }
    const int at = checksum_byte(layout, frame.size);
    if (at >= 0) {
        const auto expected = checksum(layout.checksum, frame.data.data(), frame.size);
        const auto found = frame.data[static_cast<std::size_t>(at)];
        if (found != expected)
            return wrong(Errc::bad_checksum, info, "checksum", found, expected);
    }
    return std::nullopt;
}

std::optional<Error> decode_value(const Info& info, const Field& f, const Frame& frame, std::int64_t& value)
{
    const bool clean = get(f, frame.data.data(), value);
    const Range range = allowed(f);
    if (clean && range.contains(value))
        return std::nullopt;
    Error error{.code = Errc::out_of_range,
                .message = info.name,
                .field = f.name,
                .value = value,
                .low = range.low,
                .high = range.high};
    if (!clean) {
        error.code = Errc::bad_constant;
        error.detail = std::string(f.name) + " has a bit set that this coding never sets";
    }
    return error;
}

std::optional<Error> decode_sequence(const Info& info, const Side& side, const Field& f, const Frame& frame,
                                     Values& values)
{
    const std::int64_t count = values.all().empty() ? 0 : values.all().back().raw;
    if (frame.size != side.size + 2 * count)
        return wrong(Errc::bad_length, info, f.name, frame.size, side.size + 2 * count);
    for (std::int64_t i = 0; i < 2 * count; ++i) {
        const std::int64_t value = frame.data[f.byte + static_cast<std::size_t>(i)];
        if (!f.range.contains(value))
            return detail::explain_value(info, f, value);
        values.add(f, value);
    }
    return std::nullopt;
}

} // namespace

std::optional<std::int64_t> Values::find(std::string_view name) const
{
    for (const auto& value : all())
        if (value.field->name == name)
            return value.raw;
    return std::nullopt;
}

Values value_fields(const Side& side, Options options, std::optional<std::int64_t> selector)
{
    Values out;
    const Variant* variant = variant_of(side, selector);
    for (const auto& f : side.fields) {
        if (!carries_meaning(f, options))
            continue;
        if (variant && f.name == side.replaced)
            for (const auto& inner : variant->fields)
                out.add(inner, 0);
        else
            out.add(f, 0);
    }
    return out;
}

Range request_ids(const MessageInfo& message)
{
    return message.request.exists() && has_id(message.request) ? ids_of(message.request) : Range{-1, -1};
}

std::expected<Frame, Error> encode(const MessageInfo& message, Direction direction, int id, const Values& values,
                                   Options options)
{
    const Side& side = message.side(direction);
    const Layout& layout = *side.layout;
    Frame frame{.can_id = layout.can_base, .size = side.size};
    if (has_id(side) && !ids_of(side).contains(id))
        return std::unexpected(detail::explain_id(message.info, ids_of(side), id));
    if (layout.can_base != 0 && !layout.can_fixed) {
        if (direction == Direction::reply && options.can_reply_base != 0)
            frame.can_id = options.can_reply_base;
        frame.can_id += static_cast<std::uint32_t>(id);
    }
    for (const auto& f : side.fields) {
        if (f.kind == Kind::constant || f.kind == Kind::reserved || f.kind == Kind::size)
            put(f, f.fixed, frame.data.data());
        if (f.kind == Kind::opcode)
            put(f, options.has(side.also_when) ? side.opcode_also : f.fixed, frame.data.data());
        if (f.kind == Kind::address)
            put(f, id, frame.data.data());
    }
    std::int64_t count = 0; // of the sequence: the field before it
    const auto selector = side.selector.empty() ? std::nullopt : values.find(side.selector);
    for (const auto& [field, unused] : value_fields(side, options, selector)) {
        if (field->kind == Kind::sequence) {
            const auto given =
                std::ranges::count(values.all(), field->name, [](const Value& v) { return v.field->name; });
            if (given != 2 * count)
                return std::unexpected(wrong(Errc::bad_length, message.info, field->name, given, 2 * count));
            for (const auto& value : values)
                if (value.field->name == field->name) {
                    if (!field->range.contains(value.raw))
                        return std::unexpected(detail::explain_value(message.info, *field, value.raw));
                    frame.data[frame.size - 1U] = static_cast<std::uint8_t>(value.raw);
                    ++frame.size;
                }
            continue;
        }
        const auto raw = values.find(field->name);
        if (!raw)
            return std::unexpected(
                Error{.code = Errc::missing_field, .message = message.info.name, .field = field->name});
        if (!allowed(*field).contains(*raw))
            return std::unexpected(detail::explain_value(message.info, *field, *raw));
        put(*field, *raw, frame.data.data());
        count = *raw;
    }
    for (const auto& f : side.fields)
        if (f.kind == Kind::repeat)
            frame.data[f.byte] = frame.data[f.source];
    if (const int at = checksum_byte(layout, frame.size); at >= 0)
        frame.data[static_cast<std::size_t>(at)] = checksum(layout.checksum, frame.data.data(), frame.size);
    return frame;
}

std::expected<AddressedValues, Error> decode(const MessageInfo& message, Direction direction, const Frame& frame,
                                             Options options)
{
    const Side& side = message.side(direction);
    const Info& info = message.info;
    const auto refuse = [&](Error error) {
        const std::span<const std::uint8_t> data = frame.data;
        keep_seen(error, data.first(std::min<std::size_t>(frame.size, data.size())));
        return std::unexpected(std::move(error));
    };
    const bool grows = field_of_kind(side, Kind::sequence) != nullptr;
    if (grows ? frame.size < side.size || frame.size > Frame::capacity : frame.size != side.size)
        return refuse(wrong(Errc::bad_length, info, {}, frame.size, side.size));
    if (auto error = check_framing(info, side, frame))
        return refuse(*std::move(error));
    AddressedValues out{.id = address_of(side, frame, options, direction)};
    if (side.layout->can_fixed && frame.can_id != side.layout->can_base)
        return refuse(wrong(Errc::bad_constant, info, "identifier", frame.can_id, side.layout->can_base));
    if (has_id(side) && !ids_of(side).contains(out.id))
        return refuse(detail::explain_id(info, ids_of(side), out.id));
    for (const auto& f : side.fields)
        if (f.kind == Kind::repeat && frame.data[f.byte] != frame.data[f.source]) {
            Error error = wrong(Errc::bad_repeat, info, f.name, frame.data[f.byte], frame.data[f.source]);
            return refuse(std::move(error));
        }
    std::optional<std::int64_t> selector;
    if (!side.selector.empty())
        for (const auto& f : side.fields)
            if (std::int64_t value{}; f.name == side.selector && get(f, frame.data.data(), value))
                selector = value;
    for (const auto& [field, unused] : value_fields(side, options, selector)) {
        std::int64_t value{};
        auto error = field->kind == Kind::sequence ? decode_sequence(info, side, *field, frame, out.values)
                                                   : decode_value(info, *field, frame, value);
        if (error)
            return refuse(*std::move(error));
        if (field->kind != Kind::sequence)
            out.values.add(*field, value);
    }
    return out;
}

namespace detail {

Error explain_id(const Info& info, const Range& ids, std::int64_t id)
{
    return {.code = Errc::bad_id, .message = info.name, .field = "id", .value = id, .low = ids.low, .high = ids.high};
}

Error explain_value(const Info& info, const Field& field, std::int64_t value)
{
    const Range range = allowed(field);
    return {.code = Errc::out_of_range,
            .message = info.name,
            .field = field.name,
            .value = value,
            .low = range.low,
            .high = range.high};
}

Error explain_frame(const MessageInfo& message, Direction direction, const Frame& frame, Options options)
{
    auto result = wire::decode(message, direction, frame, options);
    if (!result)
        return std::move(result.error());
    return {.code = Errc::bad_reply, .message = message.info.name};
}

} // namespace detail
} // namespace sinew::wire
