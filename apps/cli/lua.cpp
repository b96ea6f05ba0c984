#include "apps/cli/formats.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>

namespace sinew::cli {
namespace {

using wire::Coding;
using wire::Field;
using wire::Kind;
using wire::MessageInfo;
using wire::Side;

/// Reads what the tables say. Wireshark 4 has Lua 5.2: no operators for bits, so arithmetic does it.
constexpr std::string_view engine = R"lua(
local sinew = Proto("sinew", "sinew actuators")
local f_family = ProtoField.string("sinew.family", "Family")
local f_message = ProtoField.string("sinew.message", "Message")
local f_direction = ProtoField.string("sinew.direction", "Direction")
local f_id = ProtoField.uint32("sinew.id", "Id")
local f_error = ProtoField.string("sinew.error", "Error")
local registered = { f_family, f_message, f_direction, f_id, f_error }
-- Values of these names stand beside: Wireshark knows a name once.
local taken = {family = true, message = true, direction = true, id = true, error = true}
local f_values = {}
for _, name in ipairs(value_names) do
    f_values[name] = ProtoField.double((taken[name] and "sinew.value." or "sinew.") .. name, name)
    registered[#registered + 1] = f_values[name]
end
sinew.fields = registered

local get_can_id = Field.new("can.id")
local get_direction = Field.new("frame.packet_flags_direction")
local get_interface = Field.new("frame.interface_id")
local get_family = Field.new("frame.interface_description")

local function bits(value, msb, lsb)
    return math.floor(value / 2 ^ lsb) % 2 ^ (msb - lsb + 1)
end

local function raw_value(f, at)
    if f.coding == "bits" then return bits(at(f.byte), f.msb, f.lsb) end
    if f.coding == "signed_septets" then
        local magnitude = at(f.byte) % 128 * 128 + at(f.byte + 1) % 128
        return at(f.byte) >= 128 and -magnitude or magnitude
    end
    if f.coding == "septets" then
        local value = at(f.byte) % 2 ^ f.top
        for i = 1, f.bytes - 1 do value = value * 128 + at(f.byte + i) % 128 end
        return value
    end
    local value = 0
    for i = 0, f.bytes - 1 do
        value = value * 256 + at(f.byte + (f.coding == "u_be" and i or f.bytes - 1 - i))
    end
    if f.coding == "i_le" and value >= 2 ^ (8 * f.bytes - 1) then value = value - 2 ^ (8 * f.bytes) end
    return value
end

-- A sequence is a byte after another, up to what stands behind it.
local function spread(fields, side, size)
    local out = {}
    for _, f in ipairs(fields) do
        for byte = f.byte, f.sequence and size - 1 - (side.size - f.byte) or f.byte do
            local one = f.sequence and {name = f.name, byte = byte, bytes = 1, coding = "bits", msb = 7, lsb = 0} or f
            table.insert(out, one)
        end
    end
    return out
end

-- Some fields take the place of another one while a third has a value.
local function fields_of(side, at)
    local variant = side.variants and side.variants[raw_value(side.selector, at)]
    if not variant then return side.fields end
    local out = {}
    for _, f in ipairs(side.fields) do
        if f.name ~= side.replaced then out[#out + 1] = f end
    end
    for _, f in ipairs(variant) do out[#out + 1] = f end
    return out
end

local function fits(side, size, at)
    if size ~= side.size and not (side.grows and size > side.size) then return false end
    for _, c in ipairs(side.fixed) do
        -- a byte under a mask of adjacent bits
        if bits(at(c[1]), c[2], c[3]) ~= c[4] then return false end
    end
    return true
end

-- How much of a message is fixed: another one may have a value in the same bits.
local function weight(message, side, direction)
    -- a reply may have an entry of its own beside the request that asks for it
    local sum = direction == "reply" and not message.request and 1000 or 0
    for _, c in ipairs(side.fixed) do sum = sum + c[2] - c[3] + 1 end
    return sum
end

local function find(family, direction, size, at)
    local best, most
    for _, message in ipairs(family.messages) do
        local side = message[direction]
        if side and fits(side, size, at) then
            local w = weight(message, side, direction)
            if not best or w > most then best, most = message, w end
        end
    end
    if best then return best, best[direction] end
end

local asked = {}   -- the latest request on each interface, in the first pass
local answers = {} -- what a packet answers, by its number

local function dissect(tvb, pinfo, root, family_name, can_id)
    local family = families[family_name]
    local at = function(i) return tvb(i, 1):uint() end
    local size = tvb:len()
    local flag = get_direction()
    local direction = flag and flag.value == 1 and "reply" or "request"
    local interface = get_interface() and get_interface().value or 0
    local message, side
    if direction == "reply" and family.bare then
        if not pinfo.visited then
            answers[pinfo.number] = asked[interface]
            asked[interface] = nil
        end
        message = answers[pinfo.number]
        side = message and message.reply
        if not side or not fits(side, size, at) then message = nil end
    else
        message, side = find(family, direction, size, at)
        if not message and not flag then
            direction = "reply"
            message, side = find(family, direction, size, at)
        end
        if direction == "request" and not pinfo.visited then asked[interface] = message end
    end
    pinfo.cols.protocol = family_name
    local tree = root:add(sinew, tvb())
    tree:add(f_family, family_name)
    if not message then
        tree:add(f_error, "no message of this family looks like this")
        pinfo.cols.info = "no message"
        return
    end
    tree:add(f_message, message.name)
    tree:add(f_direction, direction)
    local words = message.name .. (direction == "reply" and " reply" or "")
    if can_id and can_id ~= 0x280 then tree:add(f_id, can_id % 64 + (can_id % 64 == 0 and 64 or 0)) end
    for _, f in ipairs(spread(fields_of(side, at), side, size)) do
        if f.byte + f.bytes <= size then
            local raw = raw_value(f, at)
            if f.id then
                tree:add(f_id, tvb(f.byte, f.bytes), raw)
            else
                local value = f.scale and raw * f.scale + f.offset or raw
                local label = f.labels and f.labels[raw]
                local item = tree:add(f_values[f.name], tvb(f.byte, f.bytes), value)
                item:append_text((f.unit and " " .. f.unit or "") .. (label and " (" .. label .. ")" or ""))
                words = words .. ", " .. f.name .. " " .. value .. (f.unit and " " .. f.unit or "")
            end
        end
    end
    pinfo.cols.info = words
end

function sinew.dissector(tvb, pinfo, root)
    if tvb:len() == 0 then return end
    local said = get_family() and tostring(get_family().value) or ""
    local can_id = get_can_id()
    if can_id then
        dissect(tvb, pinfo, root, "rmd", can_id.value)
    elseif families[said] then
        dissect(tvb, pinfo, root, said)
    else
        dissect(tvb, pinfo, root, tvb:len() > 1 and tvb(0, 2):uint() == 0xFFFE and "nuri" or "sam")
    end
end

DissectorTable.get("wtap_encap"):add((wtap or wtap_encaps).USER0, sinew)
for _, id in ipairs(can_ids) do DissectorTable.get("can.id"):add(id, sinew) end
)lua";

std::string_view to_word(Coding coding)
{
    constexpr std::string_view words[] = {"bits", "u_le", "i_le", "u_be", "septets", "signed_septets"};
    return words[static_cast<std::size_t>(coding)];
}

/// The constants of a side as {byte, msb, lsb, value}.
std::string fixed_of(const Side& side)
{
    std::string out;
    for (const auto& field : side.fields) {
        if (field.kind != Kind::constant && field.kind != Kind::opcode && field.kind != Kind::size)
            continue;
        std::array<std::uint8_t, wire::Frame::capacity> data{};
        wire::put(field, field.fixed, data.data());
        for (std::size_t byte = field.byte; byte < std::size_t{field.byte} + field.bytes; ++byte) {
            const bool bits = field.coding == Coding::bits;
            const int msb = bits ? field.msb : 7, lsb = bits ? field.lsb : 0;
            out += fmt::format("{{{},{},{},{}}},", byte, msb, lsb, data[byte] >> lsb);
        }
    }
    return out;
}

std::string field_text(const MessageInfo& message, const Field& field, const wire::Profile& line)
{
    std::string out = fmt::format("{{name=\"{}\",byte={},bytes={},coding=\"{}\",msb={},lsb={},top={}", field.name,
                                  field.byte, field.bytes, to_word(field.coding), field.msb, field.lsb, field.top_bits);
    if (field.kind == Kind::address)
        return out + ",id=true}";
    if (field.kind == Kind::sequence)
        return out + ",sequence=true}";
    const auto reading = wire::reading(message, field, line.overrides);
    if (!field.unit.empty() && reading.scale != wire::by_model)
        out += fmt::format(",scale={},offset={},unit=\"{}\"", reading.scale, reading.offset, field.unit);
    if (!field.labels.empty()) {
        out += ",labels={";
        for (const auto& label : field.labels)
            out += fmt::format("[{}]=\"{}\",", label.value, label.name);
        out += '}';
    }
    return out + '}';
}

std::string variants_text(const MessageInfo& message, const Side& side, const wire::Profile& line,
                          std::set<std::string>& names)
{
    const auto selector = std::ranges::find(side.fields, side.selector, &Field::name);
    if (side.variants.empty() || selector == side.fields.end())
        return {};
    std::string variants;
    for (const auto& variant : side.variants) {
        variants += fmt::format("[{}]={{", variant.selector);
        for (const auto& field : variant.fields) {
            names.emplace(field.name);
            variants += field_text(message, field, line) + ',';
        }
        variants += "},";
    }
    return fmt::format(",selector={},replaced=\"{}\",variants={{{}}}", field_text(message, *selector, line),
                       side.replaced, variants);
}

std::string side_text(const MessageInfo& message, const Side& side, const wire::Profile& line,
                      std::set<std::string>& names)
{
    bool grows = false;
    std::string fields;
    for (const auto& field : side.fields) {
        grows = grows || field.kind == Kind::sequence;
        const bool has_value = field.kind == Kind::value || field.kind == Kind::sequence;
        if ((!has_value && field.kind != Kind::address) || !field.when.holds(line.options))
            continue;
        if (has_value)
            names.emplace(field.name);
        fields += field_text(message, field, line) + ',';
    }
    return fmt::format("{{size={},grows={},fixed={{{}}},fields={{{}}}{}}}", side.size, grows, fixed_of(side), fields,
                       variants_text(message, side, line, names));
}

} // namespace

std::string lua_dissector()
{
    std::string tables;
    std::set<std::string> names;
    std::set<std::uint32_t> can_ids;
    for (const auto* family : families()) {
        const auto& line = *family->profiles.front();
        tables +=
            fmt::format("families.{} = {{ bare = {}, messages = {{\n", family->name, family->protocol->bare_replies());
        for (const auto* message : line.messages) {
            tables += fmt::format("  {{name=\"{}\"", message->name());
            if (message->request.exists())
                tables += ",\n   request=" + side_text(*message, message->request, line, names);
            if (message->reply.exists())
                tables += ",\n   reply=" + side_text(*message, message->reply, line, names);
            tables += "},\n";
            const auto* layout = message->request.layout;
            if (layout == nullptr || layout->can_base == 0)
                continue;
            for (auto id = layout->can_fixed ? 0 : layout->ids.low; id <= (layout->can_fixed ? 0 : layout->ids.high);
                 ++id)
                can_ids.insert(static_cast<std::uint32_t>(layout->can_base + id));
        }
        tables += "} }\n";
    }
    std::string value_names;
    for (const auto& name : names)
        value_names += fmt::format("\"{}\",", name);
    return fmt::format(
        "-- Made by sinew from its rows: serial lines (link type USER0) and CAN.\n"
        "-- Put it into the folder of plugins of Wireshark, or: tshark -X lua_script:FILE -r run.pcapng\n"
        "local families = {{}}\n{}local value_names = {{{}}}\nlocal can_ids = {{{}}}\n{}",
        tables, value_names, fmt::join(can_ids, ","), engine);
}

} // namespace sinew::cli
