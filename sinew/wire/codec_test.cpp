#include "sinew/wire/codec.hpp"
#include "sinew/wire/fake_vectors.hpp"

#include <gtest/gtest.h>

/// The codec by type: what a message is in bytes, and what is refused and why.
namespace sinew::wire {
namespace {

using fake::Vector;

constexpr fake::Whole whole_message{.byte = 200,
                                    .signed_byte = -2,
                                    .low_first = 0x1234,
                                    .signed_low_first = -100,
                                    .high_first = 0xABCD,
                                    .degrees = -3,
                                    .six = 0x010203040506};
constexpr fake::Packed packed_message{.low_first = 0xFEDCBA98,
                                      .seven = -2,
                                      .mode = fake::Mode::fast,
                                      .is_hot = true,
                                      .septets = 0x3FF,
                                      .signed_septets = -129};
constexpr fake::Steps two_steps_message{.count = 2, .steps = {{{1, 2}, {254, 0}}}};

/// A frame with one byte changed, and the checksum made good again.
Frame changed(const Vector& vector, std::size_t byte, std::uint8_t to)
{
    Frame frame = vector.frame();
    frame.data[byte] = to;
    const Layout& layout = *vector.message->side(vector.direction).layout;
    if (const int at = checksum_byte(layout, frame.size); at >= 0 && static_cast<std::size_t>(at) != byte)
        frame.data[static_cast<std::size_t>(at)] = checksum(layout.checksum, frame.data.data(), frame.size);
    return frame;
}

void expect_error(const Error& error, Errc code, std::string_view message, std::string_view field, std::int64_t value,
                  std::int64_t low)
{
    EXPECT_EQ(error.code, code) << to_sentence(error);
    EXPECT_EQ(error.message, message);
    EXPECT_EQ(error.field, field);
    EXPECT_EQ(error.value, value);
    EXPECT_EQ(error.low, low);
}

template <class T>
void expect_encoded(const std::expected<Frame, Error>& frame, const T& vector)
{
    ASSERT_TRUE(frame) << to_sentence(frame.error());
    EXPECT_EQ(*frame, vector.frame());
}

TEST(Codec, EncodesEveryMessageAsItIsWrittenDown)
{
    expect_encoded(encode_request(3, whole_message), fake::whole);
    expect_encoded(encode_reply<fake::Whole>(3, packed_message), fake::packed);
    expect_encoded(encode_request(0, fake::Far{.value = 0x44}), fake::far);
    expect_encoded(encode_request(31, two_steps_message), fake::two_steps);
    expect_encoded(encode_request(31, fake::Steps{}), fake::no_steps);
    expect_encoded(encode_reply<fake::Steps>(31, fake::Count{2}), fake::count);
    expect_encoded(encode_request(4, fake::Look{}), fake::look);
    expect_encoded(encode_reply<fake::Look>(4, fake::Seen{.state = 9, .position = 0x7FF}), fake::seen);
    expect_encoded(encode_request(2, fake::Parameter{.which = 1, .value = -2}), fake::parameter);
    expect_encoded(encode_reply<fake::Parameter>(2, fake::Parameter{1, 5}, {.can_reply_base = 0x500}),
                   fake::parameter_reply);
    expect_encoded(encode_request(1, fake::Edges{.low = 10, .high = 90}), fake::edges);
    expect_encoded(encode_request(1, fake::Edges{.low = 10, .high = 90}, fake::edges_crossed.options),
                   fake::edges_crossed);
    expect_encoded(encode_request(1, fake::Edges{.low = 10, .high = 90}, {.bits = fake::other_answer}), fake::edges);
    expect_encoded(encode_reply<fake::Edges>(1, Nothing{}), fake::edges_reply);
    expect_encoded(encode_reply<fake::Edges>(1, Nothing{}, {.bits = fake::other_answer}), fake::edges_other_reply);
    expect_encoded(encode_request(77, fake::Everybody{9}), fake::everybody_asked);
    expect_encoded(encode_reply<fake::Everybody>(5, fake::Count{3}), fake::everybody_reply);
}

TEST(Codec, DecodesARequestOfEveryKind)
{
    const auto whole = decode_request<fake::Whole>(fake::whole.frame());
    ASSERT_TRUE(whole) << to_sentence(whole.error());
    EXPECT_EQ(whole->id, 3);
    EXPECT_EQ(whole->message.byte, 200);
    EXPECT_EQ(whole->message.signed_byte, -2);
    EXPECT_EQ(whole->message.low_first, 0x1234);
    EXPECT_EQ(whole->message.signed_low_first, -100);
    EXPECT_EQ(whole->message.high_first, 0xABCD);
    EXPECT_EQ(whole->message.degrees, -3);
    EXPECT_EQ(whole->message.six, 0x010203040506);

    const auto steps = decode_request<fake::Steps>(fake::two_steps.frame());
    ASSERT_TRUE(steps) << to_sentence(steps.error());
    EXPECT_EQ(steps->id, 31);
    EXPECT_EQ(steps->message.count, 2);
    EXPECT_EQ(steps->message.steps, two_steps_message.steps);
    EXPECT_TRUE(decode_request<fake::Steps>(fake::no_steps.frame()));

    const auto parameter = decode_request<fake::Parameter>(fake::parameter.frame());
    ASSERT_TRUE(parameter) << to_sentence(parameter.error());
    EXPECT_EQ(parameter->id, 2);
    EXPECT_EQ(parameter->message.which, 1);
    EXPECT_EQ(parameter->message.value, -2);

    const auto far = decode_request<fake::Far>(fake::far.frame());
    ASSERT_TRUE(far) << to_sentence(far.error());
    EXPECT_EQ(far->id, 0);
    EXPECT_EQ(far->message.value, 0x44);

    const auto everybody = decode_request<fake::Everybody>(fake::everybody_asked.frame());
    ASSERT_TRUE(everybody) << to_sentence(everybody.error());
    EXPECT_EQ(everybody->id, -1);
    EXPECT_EQ(everybody->message.value, 9);
}

TEST(Codec, DecodesAReplyOfEveryKind)
{
    const auto packed = decode_reply<fake::Whole>(fake::packed.frame());
    ASSERT_TRUE(packed) << to_sentence(packed.error());
    EXPECT_EQ(packed->id, 3);
    EXPECT_EQ(packed->message.low_first, 0xFEDCBA98);
    EXPECT_EQ(packed->message.seven, -2);
    EXPECT_EQ(packed->message.mode, fake::Mode::fast);
    EXPECT_TRUE(packed->message.is_hot);
    EXPECT_EQ(packed->message.septets, 0x3FF);
    EXPECT_EQ(packed->message.signed_septets, -129);

    const auto count = decode_reply<fake::Steps>(fake::count.frame());
    ASSERT_TRUE(count) << to_sentence(count.error());
    EXPECT_EQ(count->id, -1) << "the frame names nobody";
    EXPECT_EQ(count->message.count, 2);

    const auto seen = decode_reply<fake::Look>(fake::seen.frame());
    ASSERT_TRUE(seen) << to_sentence(seen.error());
    EXPECT_EQ(seen->message.state, 9);
    EXPECT_EQ(seen->message.position, 0x7FF);

    const auto parameter = decode_reply<fake::Parameter>(fake::parameter_reply.frame(), {.can_reply_base = 0x500});
    ASSERT_TRUE(parameter) << to_sentence(parameter.error());
    EXPECT_EQ(parameter->id, 2);
    EXPECT_EQ(parameter->message.value, 5);
}

TEST(Codec, OptionsSayWhichFieldStandsWhere)
{
    const Frame frame = fake::edges.frame();
    EXPECT_EQ(decode_request<fake::Edges>(frame)->message.low, 10);
    EXPECT_EQ(decode_request<fake::Edges>(frame)->message.high, 90);
    const Options crossed{.bits = fake::high_comes_first, .can_reply_base = 0x500};
    const auto other = decode_request<fake::Edges>(frame, crossed);
    ASSERT_TRUE(other) << "the base of replies is none of requests";
    EXPECT_EQ(other->id, 1);
    EXPECT_EQ(other->message.low, 90);
    EXPECT_EQ(other->message.high, 10);
    EXPECT_EQ(encode_request(1, fake::Edges{.low = 10, .high = 100}, crossed).error().value, 100);
}

TEST(Codec, BothOpcodesOfAReplyAreTaken)
{
    EXPECT_TRUE(decode_reply<fake::Edges>(fake::edges_reply.frame()));
    EXPECT_TRUE(decode_reply<fake::Edges>(fake::edges_other_reply.frame()));
    const auto other = decode_reply<fake::Edges>(changed(fake::edges_reply, 0, 0x77));
    ASSERT_FALSE(other);
    expect_error(other.error(), Errc::bad_constant, "edges", "opcode", 0x77, 0x76);
    Frame asked = fake::edges.frame();
    asked.data[0] = 0;
    EXPECT_FALSE(decode_request<fake::Edges>(asked));
}

TEST(Codec, RefusesToEncodeAnIdThatTheLayoutDoesNotHave)
{
    const auto refused_id = [](const std::expected<Frame, Error>& frame, Range ids, int id) {
        ASSERT_FALSE(frame);
        EXPECT_EQ(frame.error().field, "id");
        EXPECT_EQ(frame.error().code, Errc::bad_id);
        EXPECT_EQ(frame.error().value, id);
        EXPECT_EQ(frame.error().low, ids.low);
        EXPECT_EQ(frame.error().high, ids.high);
    };
    refused_id(encode_request(10, whole_message), {0, 9}, 10);
    refused_id(encode_request(-1, whole_message), {0, 9}, -1);
    refused_id(encode_reply<fake::Whole>(10, packed_message), {0, 9}, 10);
    refused_id(encode_request(32, fake::Look{}), {0, 31}, 32);
    refused_id(encode_request(0, fake::Parameter{}), {1, 32}, 0);
    refused_id(encode_request(33, fake::Parameter{}), {1, 32}, 33);
    EXPECT_TRUE(encode_request(32, fake::Parameter{}));
    EXPECT_TRUE(encode_request(9, whole_message));
}

TEST(Codec, RefusesToEncodeAValueOutOfRangeAndNamesIt)
{
    const auto refused = [](fake::Whole message, std::string_view field, std::int64_t value, Range range) {
        const auto frame = encode_request(3, message);
        ASSERT_FALSE(frame) << field;
        expect_error(frame.error(), Errc::out_of_range, "whole", field, value, range.low);
        EXPECT_EQ(frame.error().high, range.high);
    };
    fake::Whole message = whole_message;
    message.byte = 0;
    refused(message, "byte", 0, {1, 200});
    message.byte = 201;
    refused(message, "byte", 201, {1, 200});
    message = whole_message;
    message.signed_low_first = 101;
    refused(message, "signed_low_first", 101, {-100, 100});
    message = whole_message;
    message.six = -1;
    refused(message, "six", -1, {0, 281'474'976'710'655});
    message.six = std::int64_t{1} << 48;
    refused(message, "six", std::int64_t{1} << 48, {0, 281'474'976'710'655});
    message.byte = 0;
    refused(message, "byte", 0, {1, 200}); // the first of two

    fake::Packed reply = packed_message;
    reply.septets = 0x400;
    expect_error(encode_reply<fake::Whole>(3, reply).error(), Errc::out_of_range, "whole", "septets", 0x400, 0);
    reply = packed_message;
    reply.mode = fake::Mode{3};
    expect_error(encode_reply<fake::Whole>(3, reply).error(), Errc::out_of_range, "whole", "mode", 3, 0);
}

TEST(Codec, RefusesToEncodeABadSequence)
{
    fake::Steps steps = two_steps_message;
    steps.count = 10;
    expect_error(encode_request(1, steps).error(), Errc::out_of_range, "steps", "count", 10, 0);
    steps = two_steps_message;
    steps.steps[1].first = 255;
    expect_error(encode_request(1, steps).error(), Errc::out_of_range, "steps", "steps", 255, 0);
    steps.steps[1] = {0, 255};
    expect_error(encode_request(1, steps).error(), Errc::out_of_range, "steps", "steps", 255, 0);
    steps.count = 1; // what is not sent may be anything
    EXPECT_TRUE(encode_request(1, steps));
    steps.count = 9;
    steps.steps = {{{9, 8}, {7, 6}, {5, 4}, {3, 2}, {1, 0}, {0, 1}, {2, 3}, {4, 5}, {254, 254}}};
    const auto full = encode_request(1, steps);
    ASSERT_TRUE(full);
    EXPECT_EQ(full->size, Frame::capacity);
    EXPECT_EQ(decode_request<fake::Steps>(*full)->message.steps, steps.steps);
}

template <class M>
void expect_request_refused(const Vector& vector, std::size_t byte, std::uint8_t to, Errc code, std::string_view field,
                            std::int64_t low)
{
    const Frame frame = changed(vector, byte, to);
    const auto decoded = decode_request<M>(frame);
    ASSERT_FALSE(decoded) << "byte " << byte;
    EXPECT_EQ(decoded.error().code, code) << to_sentence(decoded.error());
    EXPECT_EQ(decoded.error().field, field);
    EXPECT_EQ(decoded.error().low, low);
    EXPECT_GT(decoded.error().seen_size, 0) << "no evidence";
}

TEST(Codec, RefusesAByteThatMustHaveOneValue)
{
    expect_request_refused<fake::Whole>(fake::whole, 0, 0xA4, Errc::bad_constant, "header", 0xA5);
    expect_request_refused<fake::Whole>(fake::whole, 1, 0xA5, Errc::bad_constant, "second_header", 0x5A);
    expect_request_refused<fake::Whole>(fake::whole, 3, 0x15, Errc::bad_constant, "size", 0x14);
    expect_request_refused<fake::Whole>(fake::whole, 5, 0x91, Errc::bad_constant, "opcode", 0x11);
    expect_request_refused<fake::Far>(fake::far, 8, 0x32, Errc::bad_constant, "tail", 0x33);
    expect_request_refused<fake::Steps>(fake::two_steps, 1, 0x9F, Errc::bad_constant, "mode", 5);
}

TEST(Codec, RefusesABadIdChecksumRepeatOrValue)
{
    expect_request_refused<fake::Whole>(fake::whole, 2, 10, Errc::bad_id, "id", 0);
    expect_request_refused<fake::Whole>(fake::whole, 4, 0xAA, Errc::bad_checksum, "checksum", 0xA9);
    expect_request_refused<fake::Look>(fake::look, 3, 0x07, Errc::bad_checksum, "checksum", 0x06);
    expect_request_refused<fake::Steps>(fake::two_steps, 9, 0x60, Errc::bad_checksum, "checksum", 0x6E);
    expect_request_refused<fake::Far>(fake::far, 7, 0x45, Errc::bad_repeat, "value_again", 0x44);
    expect_request_refused<fake::Whole>(fake::whole, 6, 0, Errc::out_of_range, "byte", 1);
    expect_request_refused<fake::Whole>(fake::whole, 6, 201, Errc::out_of_range, "byte", 1);
    expect_request_refused<fake::Steps>(fake::two_steps, 5, 255, Errc::out_of_range, "steps", 0);
    expect_request_refused<fake::Steps>(fake::two_steps, 6, 255, Errc::out_of_range, "steps", 0);
    expect_request_refused<fake::Steps>(fake::two_steps, 3, 1, Errc::bad_length, "steps", 8);
    expect_request_refused<fake::Steps>(fake::two_steps, 3, 3, Errc::bad_length, "steps", 12);
}

TEST(Codec, RefusesAReplyWithABitThatItsCodingNeverSets)
{
    const auto septets = decode_reply<fake::Whole>(changed(fake::packed, 18, 0x08));
    ASSERT_FALSE(septets);
    EXPECT_EQ(septets.error().code, Errc::bad_constant);
    EXPECT_EQ(septets.error().field, "septets");
    EXPECT_EQ(to_sentence(septets.error()).find("whole: septets has a bit set that this coding never sets"), 0U)
        << to_sentence(septets.error());
    EXPECT_FALSE(decode_reply<fake::Whole>(changed(fake::packed, 21, 0x80)));
    EXPECT_TRUE(decode_reply<fake::Whole>(changed(fake::packed, 17, 0x5F))) << "reserved bits may be anything";
}

TEST(Codec, RefusesAFrameOfAnotherLength)
{
    const auto refused = [](const Frame& frame, std::int64_t expected, const auto& decoded) {
        ASSERT_FALSE(decoded);
        EXPECT_EQ(decoded.error().code, Errc::bad_length);
        EXPECT_EQ(decoded.error().value, frame.size);
        EXPECT_EQ(decoded.error().low, expected);
    };
    Frame frame = fake::look.frame();
    frame.size = 3;
    refused(frame, 4, decode_request<fake::Look>(frame));
    frame.size = 5;
    refused(frame, 4, decode_request<fake::Look>(frame));
    frame = fake::no_steps.frame();
    frame.size = 5;
    refused(frame, 6, decode_request<fake::Steps>(frame));
    frame.size = Frame::capacity + 1; // bytes that the frame does not have are not looked at
    refused(frame, 6, decode_request<fake::Steps>(frame));
    frame = fake::count.frame();
    frame.size = 1;
    refused(frame, 2, decode_reply<fake::Steps>(frame));
}

TEST(Codec, RefusesAnotherCanIdentifier)
{
    Frame frame = fake::everybody_asked.frame();
    frame.can_id = 0x281;
    const auto everybody = decode_request<fake::Everybody>(frame);
    ASSERT_FALSE(everybody);
    expect_error(everybody.error(), Errc::bad_constant, "everybody", "identifier", 0x281, 0x280);

    frame = fake::parameter.frame();
    for (const std::uint32_t id : {0U, 33U}) {
        frame.can_id = 0x140 + id;
        const auto parameter = decode_request<fake::Parameter>(frame);
        ASSERT_FALSE(parameter) << id;
        expect_error(parameter.error(), Errc::bad_id, "parameter", "id", id, 1);
    }
    frame.can_id = 0x13F;
    EXPECT_EQ(decode_request<fake::Parameter>(frame).error().value, -1);
}

TEST(Codec, OfAnAnswerThatWasFoundByItsChecksumOnlyTheValuesAreLookedAt)
{
    Frame frame = changed(fake::packed, 4, 0);
    EXPECT_FALSE(decode_reply<fake::Whole>(frame));
    const auto answer = decode_answer<fake::Whole>(frame);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->seven, -2);
    EXPECT_EQ(answer->septets, 0x3FF);
    frame.data[17] = 0x70; // mode 3
    const auto bad = decode_answer<fake::Whole>(changed(fake::packed, 17, 0x70));
    ASSERT_FALSE(bad);
    expect_error(bad.error(), Errc::out_of_range, "whole", "mode", 3, 0);
}

TEST(Codec, AnAnswerWithoutAChecksumIsLookedAtAsAWhole)
{
    EXPECT_EQ(decode_answer<fake::Steps>(fake::count.frame())->count, 2);
    EXPECT_EQ(decode_answer<fake::Steps>(changed(fake::count, 1, 3)).error().code, Errc::bad_repeat);
    Frame frame = fake::parameter.frame();
    frame.can_id = 0x140;
    EXPECT_EQ(decode_answer<fake::Parameter>(frame).error().code, Errc::bad_id);
}

TEST(Codec, LeavesOutACheckOnlyWhereTheTypeCanHoldNothingElse)
{
    EXPECT_TRUE(detail::fits_always<std::uint8_t>({0, 255}));
    EXPECT_FALSE(detail::fits_always<std::uint8_t>({0, 254}));
    EXPECT_FALSE(detail::fits_always<std::uint8_t>({1, 255}));
    EXPECT_TRUE(detail::fits_always<std::int16_t>({-32768, 32767}));
    EXPECT_FALSE(detail::fits_always<std::int16_t>({0, 65535}));
    EXPECT_TRUE(detail::fits_always<bool>({0, 1}));
    EXPECT_FALSE(detail::fits_always<bool>({0, 0}));
    EXPECT_FALSE(detail::fits_always<bool>({1, 1}));
    EXPECT_TRUE(detail::fits_always<std::int64_t>({}));
    EXPECT_FALSE(detail::fits_always<std::int64_t>({0, 1}));
    EXPECT_FALSE(detail::fits_always<std::uint64_t>({})) << "what is above the range of a raw value would be negative";
    EXPECT_FALSE(detail::fits_always<fake::Mode>({0, 255}));
}

} // namespace
} // namespace sinew::wire
