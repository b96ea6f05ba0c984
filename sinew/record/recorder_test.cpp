#include "sinew/record/recorder.hpp"

#include "tests/support/allocations.hpp"

#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>

namespace sinew::record {
namespace {

using namespace std::chrono_literals;

constexpr Time begin{Duration{1'700'000'000'000'000'000}};

struct Told {
    std::string topic;
    std::uint64_t at_ns;
    std::uint32_t sequence;
    std::string text;
};

class RecorderTest : public testing::Test
{
protected:
    RecorderTest() : folder_(std::filesystem::temp_directory_path() / fmt::format("sinew-recorder-{}", ::getpid()))
    {
        std::filesystem::create_directories(folder_);
    }
    ~RecorderTest() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path path() const { return folder_ / "run.mcap"; }
    std::string file() const
    {
        std::ifstream in(path(), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    std::vector<Told> read(std::vector<std::string>* errors = nullptr) const
    {
        mcap::Reader reader;
        const auto all = file();
        reader.feed(bytes_of(all));
        reader.end();
        std::vector<Told> out;
        for (;;) {
            const auto item = reader.next();
            if (!item) {
                if (errors != nullptr)
                    errors->push_back(item.error().detail);
                else
                    ADD_FAILURE() << item.error().detail;
            } else if (!*item) {
                return out;
            } else if (const auto* m = std::get_if<mcap::Message>(&**item)) {
                out.push_back(
                    {m->channel->topic, m->stamp.log_time_ns, m->stamp.sequence, std::string(text_of(m->data))});
            }
        }
    }

    std::unique_ptr<Recorder> make(std::size_t ring_bytes = 1 << 20)
    {
        auto made = Recorder::create(path(), {.ring_bytes = ring_bytes, .zero = begin});
        EXPECT_TRUE(made);
        legs_ = (*made)->add_bus({.name = "legs", .family = "rmd", .can = true, .bit_rate = 1'000'000});
        knee_ = (*made)->add_joint({.name = "knee", .bus = "legs", .family = "rmd", .id = 1});
        return std::move(*made);
    }

    std::filesystem::path folder_;
    Recorder::Bus legs_{};
    Recorder::Joint knee_{};
};

TimePoint at(Duration since)
{
    return TimePoint{since};
}

actuator::State state_at(Duration since, double position)
{
    return {.at = at(since), .position_rad = {position, at(since)}, .temperature_c = {40.0, at(1s)}};
}

TEST_F(RecorderTest, KeepsFramesStatesCommandsAndEventsWithTheirTimes)
{
    auto recorder = make();
    const std::uint8_t bytes[] = {0x9C, 0xFF};
    EXPECT_TRUE(recorder->frame(legs_, {.at = at(1ms),
                                        .direction = wire::Direction::reply,
                                        .bytes = bytes,
                                        .can_id = 0x141,
                                        .verdict = bus::Verdict::late}));
    EXPECT_TRUE(recorder->state(knee_, state_at(1s, 0.5)));
    EXPECT_TRUE(recorder->state(knee_, state_at(2s, 0.25)));
    EXPECT_TRUE(recorder->state(knee_, state_at(2s, 0.25))); // nothing in it is new
    EXPECT_TRUE(
        recorder->command(knee_, at(3s), {.mode = actuator::Mode::position, .position_rad = -1.5, .duration = 2s}));
    EXPECT_TRUE(recorder->event(at(4s), Recorder::Level::error, "link-lost", "the \"link\" is gone"));
    ASSERT_TRUE(recorder->finish());
    const auto got = read();
    ASSERT_EQ(got.size(), 5U);
    const auto ns = [](Duration since) {
        return static_cast<std::uint64_t>((begin + since).time_since_epoch().count());
    };
    EXPECT_EQ(got[0].topic, "/bus/legs");
    EXPECT_EQ(got[0].at_ns, ns(1ms));
    EXPECT_EQ(got[0].text, R"({"direction":"reply","verdict":"late","can_id":321,"bytes":"9C FF"})");
    EXPECT_EQ(got[1].topic, "/joint/knee/state");
    EXPECT_EQ(got[1].text, R"({"position_rad":0.5,"temperature_c":40})");
    EXPECT_EQ(got[2].text, R"({"position_rad":0.25})") << "the temperature is no newer than before";
    EXPECT_EQ(got[2].at_ns, ns(2s));
    EXPECT_EQ(got[2].sequence, 1U);
    EXPECT_EQ(got[3].topic, "/joint/knee/command");
    EXPECT_EQ(got[3].text, R"({"mode":"position","position_rad":-1.5,"duration_s":2})");
    EXPECT_EQ(got[4].topic, "/events");
    EXPECT_EQ(got[4].text, R"({"level":"error","name":"link-lost","text":"the \"link\" is gone"})");
}

TEST_F(RecorderTest, APushAsksNothingOfTheHeap)
{
    auto recorder = make();
    const std::uint8_t bytes[8] = {};
    const auto before = support::allocations();
    for (int i = 0; i < 1000; ++i) {
        recorder->frame(legs_, {.bytes = bytes, .can_id = 0x141});
        recorder->state(knee_, state_at(Duration{i}, 1.0));
        recorder->command(knee_, at(1s), {});
        recorder->event(at(1s), Recorder::Level::info, "tick", "tock");
    }
    EXPECT_EQ(support::allocations(), before);
    EXPECT_EQ(recorder->dropped(), 0U);
}

TEST_F(RecorderTest, AFullRingLosesAndCountsAndTheRecordingSaysSo)
{
    auto recorder = make(4096);
    while (recorder->event(at(1s), Recorder::Level::info, "tick", "tock"))
        ;
    recorder->event(at(1s), Recorder::Level::info, "tick", "tock");
    EXPECT_EQ(recorder->dropped(), 2U);
    EXPECT_GT(recorder->fill(), 0.9);
    ASSERT_TRUE(recorder->drain());
    EXPECT_TRUE(recorder->event(at(2s), Recorder::Level::info, "tick", "tock"));
    ASSERT_TRUE(recorder->finish());
    int told = 0;
    for (const auto& one : read())
        told += one.text.find("2 entries were lost") != std::string::npos;
    EXPECT_EQ(told, 1);
}

TEST_F(RecorderTest, FlushedIsInTheFileAndASecondAsWellWhateverBecomesOfTheProgram)
{
    auto recorder = make();
    std::vector<std::string> errors;
    recorder->state(knee_, state_at(1s, 1.0));
    ASSERT_TRUE(recorder->drain());
    EXPECT_EQ(read(&errors).size(), 0U);
    recorder->state(knee_, state_at(2s, 1.0));
    ASSERT_TRUE(recorder->drain());
    EXPECT_EQ(read(&errors).size(), 2U);
    recorder->state(knee_, state_at(2100ms, 1.0));
    ASSERT_TRUE(recorder->flush());
    EXPECT_EQ(read(&errors).size(), 3U);
    EXPECT_EQ(errors.size(), 3U) << "a file without its end says so";
}

TEST_F(RecorderTest, WritesFromAThreadOfItsOwn)
{
    auto recorder = make();
    recorder->run_in_thread();
    for (int i = 0; i < 10'000; ++i)
        EXPECT_TRUE(recorder->event(at(Duration{i}), Recorder::Level::info, "tick", fmt::format("{}", i)));
    ASSERT_TRUE(recorder->finish());
    const auto got = read();
    ASSERT_EQ(got.size(), 10'000U);
    EXPECT_NE(got.back().text.find("\"9999\""), std::string::npos);
}

TEST_F(RecorderTest, AFullDiskIsAnErrorThatStays)
{
    std::filesystem::create_symlink("/dev/full", folder_ / "full.mcap");
    const auto made = Recorder::create(folder_ / "full.mcap", {});
    ASSERT_FALSE(made);
    EXPECT_NE(to_sentence(made.error()).find("No space left"), std::string::npos);
    EXPECT_FALSE(Recorder::create("/is/not/here.mcap", {}));
}

} // namespace
} // namespace sinew::record
