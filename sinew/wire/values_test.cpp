#include "sinew/wire/values.hpp"

#include "sinew/wire/by_name.hpp"
#include "sinew/wire/fake_vectors.hpp"

#include <gtest/gtest.h>

/// The codec by name and number.
namespace sinew::wire {
namespace {

using fake::Vector;

TEST(Values, EncodesEveryMessageAsItIsWrittenDown)
{
    for (const Vector* v : fake::all_vectors) {
        const auto frame = encode(*v->message, v->direction, v->id, v->values(), v->options);
        ASSERT_TRUE(frame) << to_sentence(frame.error());
        EXPECT_EQ(*frame, v->frame()) << v->message->name();
    }
}

TEST(Values, TheOtherOpcodeIsOneOfReplies)
{
    const Options other{.bits = fake::other_answer};
    EXPECT_EQ(*encode(info_of<fake::Edges>, Direction::request, 1, fake::edges.values(), other), fake::edges.frame());
}

TEST(Values, DecodesEveryMessage)
{
    for (const Vector* v : fake::all_vectors) {
        const auto decoded = decode(*v->message, v->direction, v->frame(), v->options);
        ASSERT_TRUE(decoded) << to_sentence(decoded.error());
        EXPECT_EQ(decoded->id, v->id) << v->message->name();
        const Values expected = v->values();
        ASSERT_EQ(decoded->values.all().size(), expected.all().size()) << v->message->name();
        for (std::size_t i = 0; i < expected.all().size(); ++i) {
            EXPECT_EQ(decoded->values.all()[i].field->name, expected.all()[i].field->name);
            EXPECT_EQ(decoded->values.all()[i].raw, expected.all()[i].raw) << expected.all()[i].field->name;
        }
    }
}

TEST(Values, FindsTheFirstOfAName)
{
    const Values values = fake::two_steps.values();
    EXPECT_EQ(values.find("count"), 2);
    EXPECT_EQ(values.find("steps"), 1);
    EXPECT_EQ(values.find("value"), std::nullopt);
    EXPECT_EQ(Values{}.find("count"), std::nullopt);
}

TEST(Values, HoldsAsManyAsAFrameHasBytes)
{
    Values values;
    static constexpr Field field{.name = "value"};
    for (std::size_t i = 0; i < Frame::capacity; ++i)
        values.add(field, 7);
    EXPECT_EQ(values.all().size(), Frame::capacity);
}

std::vector<std::string_view> names(const Values& values)
{
    std::vector<std::string_view> out;
    for (const Value& value : values)
        out.push_back(value.field->name);
    return out;
}

TEST(ValueFields, AreThoseThatCarryMeaning)
{
    using Names = std::vector<std::string_view>;
    EXPECT_EQ(names(value_fields(info_of<fake::Far>.request, {})), Names{"value"});
    EXPECT_EQ(value_fields(info_of<fake::Far>.request, {}).find("value"), 0) << "not given yet";
    EXPECT_EQ(value_fields(info_of<fake::Parameter>.request, {}, 7).find("left"), 0);
    EXPECT_EQ(names(value_fields(info_of<fake::Steps>.request, {})), (Names{"count", "steps"}));
    EXPECT_EQ(names(value_fields(info_of<fake::Edges>.request, {})), (Names{"low", "high"}));
    EXPECT_EQ(names(value_fields(info_of<fake::Edges>.request, {.bits = fake::high_comes_first})),
              (Names{"high", "low"}));
    EXPECT_EQ(names(value_fields(info_of<fake::Parameter>.request, {})), (Names{"which", "value"}));
    EXPECT_EQ(names(value_fields(info_of<fake::Parameter>.request, {}, 6)), (Names{"which", "value"}));
    EXPECT_EQ(names(value_fields(info_of<fake::Parameter>.request, {}, 7)), (Names{"which", "left", "right"}));
}

TEST(Values, AMissingFieldIsNamed)
{
    Values values;
    values.add(*fake::field_named(info_of<fake::Parameter>.request, "which"), 7);
    values.add(*fake::field_named(info_of<fake::Parameter>.request, "value"), 7);
    const auto frame = encode(info_of<fake::Parameter>, Direction::request, 1, values);
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().code, Errc::missing_field);
    EXPECT_EQ(frame.error().message, "parameter");
    EXPECT_EQ(frame.error().field, "left");
}

/// Encodes with one number changed.
std::expected<Frame, Error> encode_with(Vector vector, std::size_t number, std::int64_t raw)
{
    vector.numbers[number].raw = raw;
    return encode(*vector.message, vector.direction, vector.id, vector.values(), vector.options);
}

TEST(Values, AValueOutOfRangeIsRefusedWithItsRange)
{
    const auto refused = [](const std::expected<Frame, Error>& frame, std::string_view field, std::int64_t value,
                            Range range) {
        ASSERT_FALSE(frame) << field;
        EXPECT_EQ(frame.error().code, Errc::out_of_range);
        EXPECT_EQ(frame.error().field, field);
        EXPECT_EQ(frame.error().value, value);
        EXPECT_EQ(frame.error().low, range.low);
        EXPECT_EQ(frame.error().high, range.high);
    };
    refused(encode_with(fake::whole, 0, 0), "byte", 0, {1, 200});
    refused(encode_with(fake::whole, 0, 201), "byte", 201, {1, 200});
    EXPECT_TRUE(encode_with(fake::whole, 0, 1));
    refused(encode_with(fake::whole, 2, 65536), "low_first", 65536, {0, 65535});
    refused(encode_with(fake::parameter_halves, 1, 51), "left", 51, {0, 50});
    refused(encode_with(fake::two_steps, 1, 255), "steps", 255, {0, 254});
    refused(encode_with(fake::two_steps, 4, 255), "steps", 255, {0, 254});
    refused(encode_with(fake::two_steps, 0, 10), "count", 10, {0, 9});
}

TEST(Values, ASequenceMustBeAsLongAsTheFieldBeforeItSays)
{
    for (const std::int64_t count : {1, 3}) {
        const auto frame = encode_with(fake::two_steps, 0, count);
        ASSERT_FALSE(frame);
        EXPECT_EQ(frame.error().code, Errc::bad_length);
        EXPECT_EQ(frame.error().field, "steps");
        EXPECT_EQ(frame.error().value, 4);
        EXPECT_EQ(frame.error().low, 2 * count);
    }
}

TEST(Values, AnIdThatTheLayoutDoesNotHaveIsRefused)
{
    const auto refused = [](const Vector& vector, int id, Range ids) {
        const auto frame = encode(*vector.message, vector.direction, id, vector.values(), vector.options);
        ASSERT_FALSE(frame) << vector.message->name();
        EXPECT_EQ(frame.error().code, Errc::bad_id);
        EXPECT_EQ(frame.error().value, id);
        EXPECT_EQ(frame.error().low, ids.low);
        EXPECT_EQ(frame.error().high, ids.high);
    };
    refused(fake::whole, 10, {0, 9});
    refused(fake::whole, -1, {0, 9});
    refused(fake::parameter, 0, {1, 32});
    refused(fake::parameter, 33, {1, 32});
    refused(fake::parameter_reply, 33, {1, 32});
}

TEST(Values, TheIdsOfARequestAreThoseThatItCanBeSentTo)
{
    EXPECT_EQ(request_ids(info_of<fake::Whole>), (Range{0, 9}));
    EXPECT_EQ(request_ids(info_of<fake::Parameter>), (Range{1, 32}));
    EXPECT_EQ(request_ids(info_of<fake::Everybody>), (Range{-1, -1})) << "it names nobody";
    MessageInfo reply_only = info_of<fake::Whole>;
    reply_only.request = {};
    EXPECT_EQ(request_ids(reply_only), (Range{-1, -1}));
}

// ---- what is refused of a frame ----

struct Refused {
    const Vector* vector;
    std::size_t byte;
    std::uint8_t to;
    Errc code;
    std::string_view field;
    std::int64_t value, low;
};

Frame with_byte(const Vector& vector, std::size_t byte, std::uint8_t to)
{
    Frame frame = vector.frame();
    frame.data[byte] = to;
    const Layout& layout = *vector.message->side(vector.direction).layout;
    const int at = checksum_byte(layout, frame.size);
    if (at >= 0 && static_cast<std::size_t>(at) != byte)
        frame.data[static_cast<std::size_t>(at)] = checksum(layout.checksum, frame.data.data(), frame.size);
    return frame;
}

TEST(Values, AFrameIsRefusedWithItsEvidence)
{
    const std::vector<Refused> all{
        {&fake::whole, 0, 0xA4, Errc::bad_constant, "header", 0xA4, 0xA5},
        {&fake::whole, 3, 0x13, Errc::bad_constant, "size", 0x13, 0x14},
        {&fake::whole, 5, 0x12, Errc::bad_constant, "opcode", 0x12, 0x11},
        {&fake::far, 8, 0x34, Errc::bad_constant, "tail", 0x34, 0x33},
        {&fake::look, 1, 0x84, Errc::bad_constant, "mode", 4, 5},
        {&fake::edges_reply, 0, 0x77, Errc::bad_constant, "opcode", 0x77, 0x76},
        {&fake::edges, 0, 0, Errc::bad_constant, "opcode", 0, 0x76},
        {&fake::whole, 4, 0xA8, Errc::bad_checksum, "checksum", 0xA8, 0xA9},
        {&fake::two_steps, 9, 0x62, Errc::bad_checksum, "checksum", 0x62, 0x6E},
        {&fake::whole, 2, 10, Errc::bad_id, "id", 10, 0},
        {&fake::far, 7, 0x43, Errc::bad_repeat, "value_again", 0x43, 0x44},
        {&fake::count, 1, 0x01, Errc::bad_repeat, "again", 0x01, 0x02},
        {&fake::whole, 6, 0, Errc::out_of_range, "byte", 0, 1},
        {&fake::whole, 6, 201, Errc::out_of_range, "byte", 201, 1},
        {&fake::packed, 17, 0x70, Errc::out_of_range, "mode", 3, 0},
        {&fake::parameter_halves, 4, 51, Errc::out_of_range, "left", 51, 0},
        {&fake::two_steps, 5, 255, Errc::out_of_range, "steps", 255, 0},
        {&fake::two_steps, 8, 255, Errc::out_of_range, "steps", 255, 0},
        {&fake::two_steps, 3, 1, Errc::bad_length, "steps", 10, 8},
        {&fake::two_steps, 3, 3, Errc::bad_length, "steps", 10, 12},
    };
    for (const Refused& r : all) {
        const auto decoded =
            decode(*r.vector->message, r.vector->direction, with_byte(*r.vector, r.byte, r.to), r.vector->options);
        ASSERT_FALSE(decoded) << r.vector->message->name() << ": " << r.field;
        const Error& error = decoded.error();
        EXPECT_EQ(error.code, r.code) << to_sentence(error);
        EXPECT_EQ(error.message, r.vector->message->name());
        EXPECT_EQ(error.field, r.field);
        EXPECT_EQ(error.value, r.value) << to_sentence(error);
        EXPECT_EQ(error.low, r.low) << to_sentence(error);
    }
}

TEST(Values, TheBytesThatWereSeenAreEvidence)
{
    const auto header = decode(info_of<fake::Look>, Direction::request, with_byte(fake::look, 0, 0xFE));
    ASSERT_FALSE(header);
    ASSERT_EQ(header.error().seen_size, 4);
    EXPECT_EQ(header.error().seen[0], 0xFE);
    EXPECT_EQ(header.error().seen[3], 0x06);
    const auto value = decode(info_of<fake::Look>, Direction::reply, with_byte(fake::seen, 0, 0xAF));
    ASSERT_FALSE(value);
    EXPECT_EQ(value.error().seen_size, 2);
    EXPECT_EQ(value.error().seen[0], 0xAF);
}

TEST(Values, ABitThatTheCodingNeverSetsIsRefusedInWords)
{
    const auto decoded = decode(info_of<fake::Whole>, Direction::reply, with_byte(fake::packed, 19, 0xFF));
    ASSERT_FALSE(decoded);
    EXPECT_EQ(decoded.error().code, Errc::bad_constant);
    EXPECT_EQ(decoded.error().detail, "septets has a bit set that this coding never sets");
    EXPECT_TRUE(decode(info_of<fake::Look>, Direction::reply, with_byte(fake::seen, 1, 0xFF))) << "it is lenient";
}

TEST(Values, AFrameOfAnotherLengthIsRefused)
{
    const auto length = [](const Vector& vector, std::size_t size) -> std::optional<std::int64_t> {
        Frame frame = vector.frame();
        frame.size = static_cast<std::uint8_t>(size);
        const auto decoded = decode(*vector.message, vector.direction, frame);
        if (decoded || decoded.error().code != Errc::bad_length || decoded.error().value != frame.size)
            return std::nullopt;
        return decoded.error().low;
    };
    EXPECT_EQ(length(fake::look, 3), 4);
    EXPECT_EQ(length(fake::look, 5), 4);
    EXPECT_EQ(length(fake::two_steps, 5), 6);
    EXPECT_EQ(length(fake::two_steps, Frame::capacity + 1), 6);
    EXPECT_EQ(length(fake::count, 1), 2);
}

TEST(Values, AnotherCanIdentifierIsRefused)
{
    const auto refused = [](const Vector& vector, std::uint32_t can_id) {
        Frame frame = vector.frame();
        frame.can_id = can_id;
        const auto decoded = decode(*vector.message, vector.direction, frame, vector.options);
        return decoded ? Error{.code = Errc::stopped} : decoded.error();
    };
    const Error everybody = refused(fake::everybody_asked, 0x281);
    EXPECT_EQ(everybody.code, Errc::bad_constant);
    EXPECT_EQ(everybody.field, "identifier");
    EXPECT_EQ(everybody.value, 0x281);
    EXPECT_EQ(everybody.low, 0x280);
    EXPECT_EQ(refused(fake::parameter, 0x140).code, Errc::bad_id);
    EXPECT_EQ(refused(fake::parameter, 0x161).value, 33);
    EXPECT_EQ(refused(fake::parameter, 0x161).high, 32);
    EXPECT_EQ(refused(fake::parameter_reply, 0x521).value, 33);
    EXPECT_EQ(refused(fake::parameter_reply, 0x142).code, Errc::bad_id) << "it is a request's";
}

// ---- a request by name ----

constexpr Profile line{.name = "line", .messages = fake::all_messages};

TEST(MakeRequest, FindsMessageAndFieldsByTheirNames)
{
    const Options options{.bits = fake::high_comes_first};
    const auto edges = make_request(line, "edges", 1, {{"low", 10}, {"unknown", 3}, {"high", 90}}, options,
                                    std::chrono::microseconds(70));
    ASSERT_TRUE(edges) << to_sentence(edges.error());
    EXPECT_EQ(edges->frame, fake::edges_crossed.frame());
    EXPECT_EQ(edges->id, 1);
    EXPECT_EQ(edges->message, &info_of<fake::Edges>);
    EXPECT_EQ(edges->options.bits, options.bits);
    EXPECT_TRUE(edges->answered);
    EXPECT_EQ(edges->response_time, std::chrono::microseconds(70));
    EXPECT_EQ(edges->replies, 0);
    EXPECT_FALSE(make_request(line, "far", 1, {{"value", 1}}, {}, {})->answered) << "the message has no reply";
}

TEST(MakeRequest, TakesTheFieldsOfTheVariant)
{
    const auto halves = make_request(line, "parameter", 32, {{"left", 50}, {"right", 200}, {"which", 7}}, {}, {});
    ASSERT_TRUE(halves) << to_sentence(halves.error());
    EXPECT_EQ(halves->frame, fake::parameter_halves.frame());
    const auto value = make_request(line, "parameter", 2, {{"value", -2}, {"which", 1}}, {}, {});
    ASSERT_TRUE(value);
    EXPECT_EQ(value->frame, fake::parameter.frame());
}

TEST(MakeRequest, SaysWhatIsMissing)
{
    const auto unlisted = make_request(line, "nothing", 4, {}, {}, {});
    ASSERT_FALSE(unlisted);
    EXPECT_EQ(unlisted.error().code, Errc::not_in_profile);
    EXPECT_EQ(unlisted.error().message, "nothing");
    EXPECT_EQ(unlisted.error().id, 4);
    EXPECT_EQ(make_request(line, "edges", 1, {{"low", 1}}, {}, {}).error().field, "high");
    EXPECT_EQ(make_request(line, "edges", 0, {{"low", 1}, {"high", 1}}, {}, {}).error().code, Errc::bad_id);
}

} // namespace
} // namespace sinew::wire
