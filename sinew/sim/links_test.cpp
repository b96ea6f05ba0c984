#include "sinew/sim/links.hpp"

#include "sinew/sim/world_test_support.hpp"

#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace sinew::sim::test {
namespace {

/// A robot file in a folder of its own.
struct SimLinksTest : testing::Test {
    void SetUp() override
    {
        std::filesystem::create_directories(folder / "sub");
        std::ofstream(path) << robot_text;
        add(links, worlds);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    std::expected<Opened, Error> open_uri(const std::string& uri) { return open(links, real, uri, worlds); }
    Errc refusal(const std::string& uri)
    {
        const auto opened = open_uri(uri);
        EXPECT_FALSE(opened) << uri;
        return opened ? Errc{} : opened.error().code;
    }

    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / ("sinew_sim_links_" + std::to_string(::getpid()));
    const std::string path = folder / "three.toml";
    link::Links links = link::Links::system();
    link::RealClock real;
    Worlds worlds;
};

TEST_F(SimLinksTest, OneFileIsOneWorldHoweverItIsWritten)
{
    auto left = open_uri("sim:" + path + "#left");
    auto waist = open_uri("sim:" + (folder / "sub" / ".." / "three.toml").string() + "#waist");
    ASSERT_TRUE(left) << to_sentence(left.error());
    ASSERT_TRUE(waist) << to_sentence(waist.error());
    EXPECT_EQ(left->clock, waist->clock);
    EXPECT_NE(left->clock, &real);
    left->clock->wait({}, TimePoint{} + 1s);
    EXPECT_EQ(waist->clock->now(), TimePoint{} + 1s);
}

TEST_F(SimLinksTest, OpensTheKindOfLinkThatTheFamilyNeeds)
{
    EXPECT_TRUE(std::holds_alternative<std::unique_ptr<link::ByteLink>>(open_uri("sim:" + path + "#left")->link));
    EXPECT_TRUE(std::holds_alternative<std::unique_ptr<link::CanLink>>(open_uri("sim:" + path + "#legs")->link));
}

TEST_F(SimLinksTest, OtherLinksKeepTheRealClock)
{
    EXPECT_EQ(clock_for("serial:/dev/null?baud=9600", real, worlds).value(), &real);
    EXPECT_EQ(clock_for("sim:" + path + "?clock=real#left", real, worlds).value(), &real);
}

TEST_F(SimLinksTest, VirtualTimeIsRefusedUnderAnotherClock)
{
    const auto link = links.open("sim:" + path + "#left", real);
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, Errc::bad_argument);
}

TEST_F(SimLinksTest, RefusesWhatIsNotThere)
{
    EXPECT_EQ(refusal("sim:" + path + "#arm"), Errc::link_not_found);
    EXPECT_EQ(refusal("sim:" + path), Errc::link_not_found);
    EXPECT_EQ(refusal("sim:" + path + "?clock=fast#left"), Errc::bad_uri);
    EXPECT_EQ(refusal("sim:" + path + "?speed=2#left"), Errc::bad_uri);
    EXPECT_EQ(refusal("sim:" + (folder / "none.toml").string() + "#left"), Errc::bad_file);
}

TEST_F(SimLinksTest, RealTimeAnswersAsHardwareDoes)
{
    auto opened = open_uri("sim:" + path + "?clock=real#waist");
    ASSERT_TRUE(opened) << to_sentence(opened.error());
    EXPECT_EQ(opened->clock, &real);
    link::ByteLink& link = bytes_of(opened->link);
    ASSERT_TRUE(link.write(nuri_ping_2));
    Bytes heard;
    const TimePoint deadline = real.now() + 5s;
    const link::Handle handles[] = {{.fd = link.handle()}};
    while (heard.size() < 6 && real.now() < deadline) {
        real.wait(handles, deadline);
        std::array<std::uint8_t, 64> into;
        const auto arrival = link.read(into);
        ASSERT_TRUE(arrival);
        heard.insert(heard.end(), into.begin(), into.begin() + arrival->count);
    }
    EXPECT_EQ(heard, nuri_pong_2);
}

} // namespace
} // namespace sinew::sim::test
