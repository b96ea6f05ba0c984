#include "sinew/family/rmd/messages.hpp"
#include "sinew/wire/select.hpp"
#include "tests/conformance/vector.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <set>
#include <sstream>

/// The rows against the reading of the manuals in the command files: two descriptions that check each other.
namespace sinew::conformance {
namespace {

using namespace wire;

/// Where a row and the command file say different things.
struct Difference {
    std::string family, command, side, field, property, detail;
};

/// A difference that is meant. "*" stands for any.
struct Deliberate {
    std::string_view family, command, field, property;
    std::string_view row; ///< what the row says; empty: anything else than the file
    std::string_view why;
};

constexpr Deliberate deliberate[] = {
    {"sam", "*", "position", "coding", "", "H5L7 or H8L7 by model: the row carries the wider one (S39)"},
    {"sam", "*", "target_position", "coding", "", "H5L7 or H8L7 by model: the row carries the wider one (S39)"},
    {"sam", "*", "position", "range", "row 0 … 32639",
     "by model: the row allows what the wider coding carries up to 255 * 128 - 1"},
    {"sam", "*", "target_position", "range", "row 0 … 32639",
     "by model: the row allows what the wider coding carries up to 255 * 128 - 1"},
    {"sam", "precise-position-control", "target_position", "range", "row 0 … 524287",
     "by model: the row is all 19 bits"},
    {"sam", "precise-position-control", "position", "range", "row 0 … 524287", "by model: the row is all 19 bits"},
    {"sam", "read-precise-position", "position", "range", "row 0 … 524287", "by model: the row is all 19 bits"},
    {"sam", "*", "model_number", "range", "row 0 … 255", "the table names the known models; a new one may answer"},
    {"sam", "set-ctrl-speed", "", "flash", "", "not stated; taken as lost at power-off (S36)"},
    {"sam", "set-ctrl-torque", "", "flash", "", "not stated; taken as lost at power-off (S36)"},
    {"sam", "set-ctrl-accel", "", "flash", "", "not stated; taken as lost at power-off (S36)"},
    {"sam", "set-ctrl-decel", "", "flash", "", "not stated; taken as lost at power-off (S36)"},
    {"sam", "offset-control", "", "flash", "", "not stated; taken as lost at power-off (S50)"},
    {"nuri", "*", "", "flash", "", "not stated; settings have a factory reset, so they persist (N14)"},
    {"rmd", "*", "encoder", "range", "row 0 … 65535",
     "the file has the 14-bit encoder; other motors send up to 16 bit"},
    {"rmd", "*", "encoder_raw", "range", "row 0 … 65535",
     "the file has the 14-bit encoder; other motors send up to 16 bit"},
    {"rmd", "*", "encoder_offset", "range", "row 0 … 65535",
     "the file has the 14-bit encoder; other motors send up to 16 bit"},
    {"rmd", "*", "result", "labels", "", "the row says it in one word"},
    {"sam", "read-temperature-error", "temp_error", "labels", "", "the row says it in one word"},
};

bool is_meant(const Difference& d, const Deliberate& m)
{
    const auto fits = [](std::string_view pattern, const std::string& text) {
        return pattern == "*" || pattern == text;
    };
    return fits(m.family, d.family) && fits(m.command, d.command) && fits(m.field, d.field) &&
           fits(m.property, d.property) && (m.row.empty() || d.detail.starts_with(std::string(m.row) + ","));
}

std::string lower(std::string text)
{
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string show(const Range& range)
{
    return range.given() ? std::to_string(range.low) + " … " + std::to_string(range.high) : "none";
}

/// Compares one command with its row and collects what differs.
class Comparison
{
public:
    Comparison(const test::Family& family, const MessageInfo& row, const json& command, std::vector<Difference>& out)
        : family_(family), row_(row), command_(command), out_(out)
    {
    }

    void run()
    {
        compare_message();
        for (const auto direction : {Direction::request, Direction::reply}) {
            side_name_ = direction == Direction::request ? "request" : "reply";
            const Side& side = row_.side(direction);
            // A Nuri reply is an entry of its own; its request only names the mode that answers.
            const bool named_only = family_.name == "nuri" && direction == Direction::reply && row_.request.exists();
            if (!named_only)
                compare_side(side, command_.at(side_name_));
        }
    }

private:
    void differ(std::string field, std::string property, std::string detail)
    {
        out_.push_back({std::string(family_.name), std::string(row_.name()), side_name_, std::move(field),
                        std::move(property), std::move(detail)});
    }

    template <class A, class B>
    void same(const std::string& field, const std::string& property, const A& row, const B& spec)
    {
        if (row == spec)
            return;
        std::ostringstream text;
        text << "row " << row << ", file " << spec;
        differ(field, property, text.str());
    }

    void compare_message()
    {
        const Info& info = row_.info;
        const auto* key = family_.name == "sam" ? "opcode" : family_.name == "nuri" ? "mode" : "command";
        same("", "opcode", info.opcode, command_.at(key).is_null() ? -1 : command_.at(key).get<int>());
        same("", "section", std::string(info.manual), command_.at("section").get<std::string>());
        std::set<std::string> errata;
        std::istringstream words{std::string(info.errata)};
        for (std::string word; words >> word;)
            errata.insert(word);
        if (errata != command_.at("errata").get<std::set<std::string>>())
            differ("", "errata", std::string(info.errata) + " / " + command_.at("errata").dump());
        const json& flash = command_.at("flash");
        if (!flash.is_null() || info.access != Access::read)
            if (flash.is_null() || flash != (info.access == Access::flash))
                differ("", "flash", flash.dump());
        same("", "access", info.access == Access::read, is_read());
        same("", "broadcast", info.broadcast, command_.at("broadcast") == true);
        if (family_.name == "sam")
            same("", "answered", info.answered_as_command, command_.at("response_class") == "command");
        if (family_.name == "nuri" && row_.request.exists())
            same("", "reply_mode", row_.reply.exists() ? info.reply_opcode : -1,
                 command_.at("reply_mode").is_null() ? -1 : command_.at("reply_mode").get<int>());
    }

    bool is_read() const
    {
        if (family_.name == "sam")
            return command_.at("response_class") == "read";
        const std::string name = command_.at("name");
        return name.starts_with("read_") || name.starts_with("request_") || name.starts_with("reply_");
    }

    void compare_side(const Side& side, const json& spec)
    {
        same("", "exists", side.exists(), !spec.is_null());
        if (!side.exists() || spec.is_null())
            return;
        const json& length = spec.at(family_.name == "rmd" ? "dlc" : "length");
        if (length.is_null())
            same("", "length", std::to_string(side.size) + " + 2*motion_count",
                 spec.at("length_formula").get<std::string>());
        else
            same("", "length", side.size, length.get<int>());
        if (family_.name == "rmd")
            compare_identifier(side, command_.at("can_id_" + side_name_));
        std::set<std::string_view> named;
        for (const auto& field : spec.at("fields")) {
            const std::string name = field.at("name");
            const Field* f = field_of(side, name);
            if (f == nullptr) {
                differ(name, "exists", "only in the file");
                continue;
            }
            named.insert(f->name);
            compare_field(side, *f, field);
        }
        for (const auto& f : side.fields)
            if (!named.contains(f.name) && f.when.holds({}) && !is_framing(f))
                differ(std::string(f.name), "exists", "only in the row");
    }

    void compare_identifier(const Side& side, const std::string& spec)
    {
        const Layout& layout = *side.layout;
        if (spec.starts_with("0x280"))
            same("", "identifier", layout.can_fixed ? layout.can_base : 0, 0x280U);
        else
            same("", "identifier", layout.can_fixed ? 0 : layout.can_base, 0x140U);
        if (!layout.can_fixed)
            same("", "ids", show(layout.ids), std::string("1 … 32"));
    }

    static const Field* field_of(const Side& side, std::string_view name)
    {
        for (const auto& f : side.fields)
            if (f.name == name && f.when.holds({}))
                return &f;
        return nullptr;
    }

    /// The framing bytes that the command files do not repeat.
    bool is_framing(const Field& f) const
    {
        if (family_.name == "sam")
            return (f.byte == 0 && f.kind == Kind::constant && f.fixed == 0xFF) || f.kind == Kind::checksum;
        return family_.name == "nuri" && f.kind == Kind::constant &&
               ((f.byte == 0 && f.fixed == 0xFF) || (f.byte == 1 && f.fixed == 0xFE));
    }

    void compare_field(const Side& side, const Field& f, const json& spec)
    {
        const std::string name = spec.at("name");
        if (spec.contains("repeat")) {
            compare_sequence(f, spec);
            return;
        }
        int first = 0;
        int count = 1;
        if (spec.contains("bytes")) {
            first = spec["bytes"][0];
            count = spec["bytes"][1].get<int>() - first + 1;
        } else {
            first = spec.at("byte");
        }
        same(name, "byte", f.byte, first);
        same(name, "bytes", f.bytes, count);
        compare_coding(f, spec, count);
        compare_kind(side, f, spec);
        if (f.kind != Kind::value && f.kind != Kind::address)
            return;
        compare_ranges(f, spec);
        compare_scale(f, spec);
        compare_labels(f, spec);
    }

    void compare_sequence(const Field& f, const json& spec)
    {
        const std::string name = spec.at("name");
        same(name, "kind", f.kind == Kind::sequence, true);
        same(name, "byte", f.byte, spec.at("byte").get<int>());
        same(name, "stride", 2, spec.at("stride").get<int>());
        for (const auto& inner : spec.at("fields"))
            same(name, "range", show(f.range), show({inner["range"][0], inner["range"][1]}));
    }

    void compare_coding(const Field& f, const json& spec, int count)
    {
        const std::string name = spec.at("name");
        const std::string type = spec.value("type", "");
        const std::string encoding = spec.value("encoding", "");
        Coding coding = Coding::bits;
        int top = 8;
        bool shares = false;
        if (encoding == "S7L7") {
            coding = Coding::signed_septets;
        } else if (!encoding.empty()) {
            coding = Coding::septets;
            top = encoding[1] - '0';
            shares = encoding == "H4L7";
            same(name, "bytes", f.bytes, encoding == "H5M7L7" ? 3 : 2);
        } else if (type.starts_with("int")) {
            coding = Coding::i_le;
            same(name, "width", 8 * f.bytes, std::stoi(type.substr(3)));
        } else if (count > 1) {
            coding = spec.value("endianness", "little") == "big" ? Coding::u_be : Coding::u_le;
        }
        if (f.coding != coding || (coding == Coding::septets && (f.top_bits != top || f.shares_top != shares)))
            differ(name, "coding", encoding + type);
        if (coding == Coding::bits) {
            const json bits = spec.value("bits", json::array({7, 0}));
            same(name, "msb", f.msb, bits[0].get<int>());
            same(name, "lsb", f.lsb, bits[1].get<int>());
        }
    }

    void compare_kind(const Side& side, const Field& f, const json& spec)
    {
        const std::string name = spec.at("name");
        Kind kind = Kind::value;
        if (spec.contains("equals_byte")) {
            kind = Kind::repeat;
            same(name, "source", f.source, spec["equals_byte"].get<int>());
        } else if (spec.contains("send") || name.starts_with("null_")) {
            kind = Kind::reserved;
            same(name, "send", f.fixed, spec.value("send", spec.value("const", 0)));
        } else if (spec.contains("const")) {
            const bool selects = name == "opcode" || name == "command" || (name == "mode" && family_.name == "nuri");
            kind = selects ? Kind::opcode : name == "size" ? Kind::size : Kind::constant;
            same(name, "const", f.fixed, spec["const"].get<int>());
        } else if (name == "checksum") {
            kind = Kind::checksum;
        } else if (name == "id" && side.layout->ids.high > 0) {
            kind = Kind::address;
        }
        same(name, "kind", static_cast<int>(f.kind), static_cast<int>(kind));
        same(name, "accept", f.kind == Kind::opcode ? side.opcode_also : -1,
             spec.contains("accept") ? spec["accept"][0].get<int>() : -1);
    }

    /// No range in the file is the whole width; an enumeration without one is its values.
    static Range range_of(const Field& f, const json& spec, const char* key)
    {
        Range out = capacity(f);
        if (spec.contains(key)) {
            if (!spec[key][0].is_null())
                out.low = spec[key][0];
            if (!spec[key][1].is_null())
                out.high = spec[key][1];
        } else if (spec.contains("range_by_model")) {
            out = {0, 0};
            for (const auto& [model, range] : spec["range_by_model"].items())
                out.high = std::max(out.high, range[1].get<std::int64_t>());
        } else if (spec.contains("enum")) {
            out = {std::numeric_limits<std::int64_t>::max(), 0};
            for (const auto& [value, label] : spec["enum"].items()) {
                out.low = std::min<std::int64_t>(out.low, std::stoll(value, nullptr, 0));
                out.high = std::max<std::int64_t>(out.high, std::stoll(value, nullptr, 0));
            }
        }
        return out;
    }

    void compare_ranges(const Field& f, const json& spec)
    {
        const std::string name = spec.at("name");
        same(name, "range", show(allowed(f)), show(range_of(f, spec, "range")));
        same(name, "recommended", show(f.recommended),
             spec.contains("recommended_range") ? show(range_of(f, spec, "recommended_range")) : "none");
    }

    void compare_scale(const Field& f, const json& spec)
    {
        const std::string name = spec.at("name");
        const auto text = [&](const char* key) {
            return spec.contains(key) && spec[key].is_string() ? spec[key].get<std::string>() : std::string();
        };
        same(name, "unit", std::string(f.unit), text("unit"));
        same(name, "scale", f.scale, spec.contains("scale_by_model") ? by_model : spec.value("scale", 1.0));
        same(name, "offset", f.offset, spec.value("offset", 0.0));
    }

    void compare_labels(const Field& f, const json& spec)
    {
        const std::string name = spec.at("name");
        std::map<std::int64_t, std::string> labels;
        const json enumerated = spec.value("enum", json::object());
        const json flags = spec.value("flags", json::object());
        for (const auto& [value, label] : enumerated.items())
            labels[std::stoll(value, nullptr, 0)] = label.is_string() ? label.get<std::string>() : label.dump();
        for (const auto& [bit, label] : flags.items())
            labels[std::int64_t{1} << std::stoi(bit)] = label;
        for (const auto& label : f.labels) {
            const auto said = labels.find(label.value);
            const bool is_same =
                said != labels.end() && lower(said->second).starts_with(lower(std::string(label.name)));
            if (!is_same && !labels.empty())
                differ(name, "labels", std::string(label.name));
            labels.erase(label.value);
        }
        for (const auto& [value, label] : labels)
            differ(name, "labels", label + " only in the file");
    }

    const test::Family& family_;
    const MessageInfo& row_;
    const json& command_;
    std::vector<Difference>& out_;
    std::string side_name_;
};

std::vector<Difference> compare(const test::Family& family)
{
    std::vector<Difference> out;
    const json file = read_data(std::string(family.name) + "-commands.json");
    EXPECT_EQ(file.at("commands").size(), family.manual.messages.size());
    for (const auto& command : file.at("commands")) {
        const auto* row = family.manual.find(with_dashes(command.at("name")));
        if (row == nullptr)
            ADD_FAILURE() << "no row for " << command.at("name");
        else
            Comparison(family, *row, command, out).run();
    }
    return out;
}

TEST(Rows, SayWhatTheCommandFilesSay)
{
    std::set<const Deliberate*> used;
    for (const auto& family : test::families())
        for (const auto& d : compare(family)) {
            bool meant = false;
            for (const auto& m : deliberate)
                if (is_meant(d, m)) {
                    meant = true;
                    used.insert(&m);
                }
            EXPECT_TRUE(meant) << d.family << " " << d.command << " " << d.side << " " << d.field << ": " << d.property
                               << " (" << d.detail << ")";
        }
    for (const auto& m : deliberate)
        EXPECT_TRUE(used.contains(&m)) << "no such difference any more: " << m.family << " " << m.command << " "
                                       << m.field << " " << m.property;
}

TEST(Rows, CountAsManyMessagesAsTheManualsHave)
{
    EXPECT_EQ(test::family("sam").manual.messages.size(), 57U);
    EXPECT_EQ(test::family("nuri").manual.messages.size(), 34U);
    EXPECT_EQ(test::family("rmd").manual.messages.size(), 28U);
}

TEST(Rows, HaveTheParametersOfTheRmdFamily)
{
    const json file = read_data("rmd-commands.json").at("parameters");
    ASSERT_EQ(file.size(), std::size(rmd::parameters));
    for (const auto& variant : rmd::parameters) {
        const json& spec = file.at(fmt::format("0x{:02X}", variant.selector));
        EXPECT_EQ(spec.at("name"), variant.name);
        ASSERT_EQ(spec.at("fields").size(), variant.fields.size()) << variant.name;
        for (std::size_t i = 0; i < variant.fields.size(); ++i) {
            const Field& f = variant.fields[i];
            const json& said = spec["fields"][i];
            EXPECT_EQ(said.at("name"), f.name);
            EXPECT_EQ(said.at("bytes")[0], f.byte) << f.name;
            EXPECT_EQ(said.at("bytes")[1], f.byte + f.bytes - 1) << f.name;
            const bool is_signed = said.at("type").get<std::string>().starts_with("int");
            EXPECT_EQ(f.coding, is_signed ? Coding::i_le : Coding::u_le) << f.name;
        }
    }
}

} // namespace
} // namespace sinew::conformance
