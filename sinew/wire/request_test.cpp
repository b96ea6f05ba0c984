#include "sinew/wire/request.hpp"

#include "sinew/wire/fake_vectors.hpp"
#include "sinew/wire/protocol.hpp"
#include "sinew/wire/select.hpp"

#include <algorithm>
#include <gtest/gtest.h>

/// Requests, what tells one message from another, and firmware lines.
namespace sinew::wire {
namespace {

using namespace std::chrono_literals;

TEST(Request, CarriesAllThatABusMustKnow)
{
    const Options options{.bits = fake::high_comes_first};
    const auto request = make_request(1, fake::Edges{.low = 10, .high = 90}, options, 5us);
    ASSERT_TRUE(request);
    EXPECT_EQ(request->id, 1);
    EXPECT_EQ(request->message, &info_of<fake::Edges>);
    EXPECT_EQ(request->frame, fake::edges_crossed.frame());
    EXPECT_EQ(request->options.bits, options.bits);
    EXPECT_TRUE(request->answered);
    EXPECT_EQ(request->response_time, 5us);
    EXPECT_EQ(request->replies, 0);
}

TEST(Request, IsAnsweredUnlessThereIsNoReplyOrItGoesToEveryDeviceAtOnce)
{
    EXPECT_TRUE(make_request(3, fake::Look{})->answered);
    EXPECT_TRUE(make_request(31, fake::Look{})->answered) << "no address for all";
    EXPECT_TRUE(make_request(30, fake::Steps{})->answered);
    EXPECT_FALSE(make_request(31, fake::Steps{})->answered) << "the highest id is all devices";
    EXPECT_FALSE(make_request(3, fake::Far{})->answered);
    EXPECT_TRUE(make_request(0, fake::Everybody{})->answered) << "each answers with its own identifier";
}

TEST(Request, IsRefusedWithTheReasonOfTheCodec)
{
    EXPECT_EQ(make_request(10, fake::Far{}).error().code, Errc::bad_id);
    const auto edges = make_request(1, fake::Edges{.low = 100});
    ASSERT_FALSE(edges);
    EXPECT_EQ(edges.error().field, "low");
    EXPECT_EQ(edges.error().value, 100);
}

TEST(Request, IsForNobodyBeforeItIsMade)
{
    const Request request;
    EXPECT_EQ(request.id, -1);
    EXPECT_EQ(request.message, nullptr);
    EXPECT_TRUE(request.answered);
    EXPECT_EQ(request.replies, 0);
    EXPECT_EQ(Addressed<fake::Look>{}.id, -1);
    EXPECT_EQ(AddressedValues{}.id, -1);
}

TEST(Requests, KeepTheirOrder)
{
    Requests requests;
    EXPECT_TRUE(requests.empty());
    for (std::size_t i = 0; i < Requests::capacity; ++i)
        requests.add(Request{.id = static_cast<int>(i)});
    EXPECT_FALSE(requests.empty());
    ASSERT_EQ(requests.all().size(), Requests::capacity);
    for (std::size_t i = 0; i < Requests::capacity; ++i)
        EXPECT_EQ(requests.all()[i].id, static_cast<int>(i));
}

// ---- which message a frame is ----

const Side& side_of(const fake::Vector& vector)
{
    return vector.message->side(vector.direction);
}

TEST(Selects, EveryFrameItsOwnSideAndNoOther)
{
    for (const auto* vector : fake::all_vectors)
        for (const MessageInfo* message : fake::all_messages)
            for (const Direction direction : {Direction::request, Direction::reply}) {
                const Side& side = message->side(direction);
                // Sides of the same bytes are told apart by identifier or direction, which is not asked here.
                if (!side.exists() || side.layout != side_of(*vector).layout ||
                    (side.opcode == side_of(*vector).opcode && message != vector->message) ||
                    side.layout == &fake::bare)
                    continue;
                const bool same = message == vector->message && side.size == side_of(*vector).size;
                const bool is_own = &side == &side_of(*vector) || (message == &info_of<fake::Parameter> && same);
                EXPECT_EQ(selects(side, vector->frame()), is_own) << message->name() << " " << vector->message->name();
            }
}

void expect_told_by(const fake::Vector& vector, std::initializer_list<std::size_t> telling)
{
    for (std::size_t byte = 0; byte < vector.bytes.size(); ++byte) {
        Frame frame = vector.frame();
        frame.data[byte] ^= 0x80;
        EXPECT_EQ(selects(side_of(vector), frame), std::ranges::find(telling, byte) == telling.end())
            << "byte " << byte;
    }
}

TEST(Selects, ByConstantsOpcodeAndSizeWithoutValuesAndChecksum)
{
    expect_told_by(fake::whole, {0, 1, 3, 5});
    expect_told_by(fake::far, {0, 1, 3, 5, 8});
    expect_told_by(fake::look, {0, 1, 2});
    expect_told_by(fake::two_steps, {0, 1, 2});
    expect_told_by(fake::edges_reply, {0});
    expect_told_by(fake::edges_other_reply, {0});
    expect_told_by(fake::count, {});
}

TEST(Selects, ByTheNumberOfBytes)
{
    const auto is_selected = [](const fake::Vector& vector, std::size_t size) {
        Frame frame = vector.frame();
        frame.size = static_cast<std::uint8_t>(size);
        return selects(side_of(vector), frame);
    };
    EXPECT_FALSE(is_selected(fake::look, 3));
    EXPECT_TRUE(is_selected(fake::look, 4));
    EXPECT_FALSE(is_selected(fake::look, 5));
    EXPECT_FALSE(is_selected(fake::far, 8));
    EXPECT_FALSE(is_selected(fake::far, 10));
    EXPECT_FALSE(is_selected(fake::edges_reply, 2));
    EXPECT_FALSE(is_selected(fake::two_steps, 5)) << "shorter than without a step";
    EXPECT_TRUE(is_selected(fake::two_steps, 6));
    EXPECT_TRUE(is_selected(fake::two_steps, 24));
}

TEST(FindField, FindsAFieldByItsNameOrNone)
{
    const Side& side = info_of<fake::Far>.request;
    EXPECT_EQ(find_field(side, "value"), &side.fields[6]);
    EXPECT_EQ(find_field(side, "header"), &side.fields[0]);
    EXPECT_EQ(find_field(side, "nothing"), nullptr);
}

// ---- firmware lines ----

constexpr const MessageInfo* two[] = {&info_of<fake::Far>, &info_of<fake::Look>};
constexpr Profile line{.name = "line", .messages = two};

TEST(Profile, HasWhatItLists)
{
    EXPECT_EQ(line.find("far"), &info_of<fake::Far>);
    EXPECT_EQ(line.find("look"), &info_of<fake::Look>);
    EXPECT_EQ(line.find("whole"), nullptr);
    EXPECT_TRUE(line.has(info_of<fake::Look>));
    EXPECT_FALSE(line.has(info_of<fake::Whole>));
    const MessageInfo twin = info_of<fake::Look>; // the same name in another line is another message
    EXPECT_FALSE(line.has(twin));
}

class ReadingOf : public ::testing::Test
{
protected:
    Reading read(std::initializer_list<Override> profile, std::initializer_list<Override> model = {})
    {
        const MessageInfo& whole = info_of<fake::Whole>;
        return reading(whole, *find_field(whole.request, "degrees"), profile, model);
    }
};

TEST_F(ReadingOf, AFieldIsAsItsRowSaysWithoutOverrides)
{
    const Reading row = read({});
    EXPECT_EQ(row.range, (Range{-2'147'483'648, 2'147'483'647}));
    EXPECT_EQ(row.scale, 0.01);
    EXPECT_EQ(row.offset, -5.0);
    EXPECT_DOUBLE_EQ(row.physical(100), -4.0);
}

TEST_F(ReadingOf, AnOverrideChangesWhatItNames)
{
    const Reading range = read({{.field = "degrees", .range = {-9, 9}}});
    EXPECT_EQ(range.range, (Range{-9, 9}));
    EXPECT_EQ(range.scale, 0.01);
    EXPECT_EQ(range.offset, -5.0);
    const Reading scale = read({{.message = "whole", .field = "degrees", .scale = 0.5, .offset = 1.0}});
    EXPECT_EQ(scale.range, (Range{-2'147'483'648, 2'147'483'647}));
    EXPECT_DOUBLE_EQ(scale.physical(4), 3.0);
}

TEST_F(ReadingOf, AnOverrideOfAnotherMessageOrFieldSaysNothing)
{
    EXPECT_EQ(read({{.message = "far", .field = "degrees", .scale = 2.0}}).scale, 0.01);
    EXPECT_EQ(read({{.message = "whole", .field = "byte", .scale = 2.0}}).scale, 0.01);
    EXPECT_EQ(read({{.field = "byte", .scale = 2.0}}).scale, 0.01);
}

TEST_F(ReadingOf, TheLaterOverrideWinsAndTheModelsIsLast)
{
    EXPECT_EQ(read({{.field = "degrees", .scale = 2.0}, {.field = "degrees", .scale = 3.0}}).scale, 3.0);
    const Reading both =
        read({{.field = "degrees", .range = {0, 5}, .scale = 2.0}}, {{.field = "degrees", .scale = 4.0}});
    EXPECT_EQ(both.scale, 4.0);
    EXPECT_EQ(both.range, (Range{0, 5}));
}

// ---- what a protocol says unless its family knows better ----

class Lines final : public Protocol
{
public:
    Scan find_request(std::span<const std::uint8_t>, bool) const override { return {}; }
    Scan find_reply(std::span<const std::uint8_t> bytes, std::size_t awaited, bool silent) const override
    {
        EXPECT_EQ(bytes.size(), 4U);
        EXPECT_EQ(awaited, 4U);
        EXPECT_FALSE(silent) << "more may come";
        return scan;
    }
    const MessageInfo* identify(const Frame&, Direction, const Profile&) const override { return nullptr; }
    int addressee(const Frame&) const override { return -1; }
    bool answers(const Frame&, const MessageInfo&, const Frame&, Options) const override { return fits; }
    std::expected<Request, Error> probe(int) const override { return std::unexpected(Error{}); }

    Scan scan{.size = 4};
    bool fits = true;
};

TEST(Protocol, IsAnsweredByOneWholeFrameThatFits)
{
    Lines lines;
    const Frame frame = fake::look.frame();
    const auto is_answer = [&] { return lines.is_answer(frame, info_of<fake::Look>, frame, {}); };
    EXPECT_TRUE(is_answer());
    lines.fits = false;
    EXPECT_FALSE(is_answer());
    lines.fits = true;
    lines.scan = {.skip = 1, .size = 3};
    EXPECT_FALSE(is_answer());
    lines.scan = {.skip = 0, .size = 3};
    EXPECT_FALSE(is_answer()) << "there is more behind it";
    lines.scan = {.skip = 1, .size = 4};
    EXPECT_FALSE(is_answer());
    EXPECT_FALSE(lines.bare_replies());
}

} // namespace
} // namespace sinew::wire
