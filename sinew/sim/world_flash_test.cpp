#include "sinew/sim/simulator.hpp"
#include "sinew/sim/world_test_support.hpp"

namespace sinew::sim::test {
namespace {

std::unique_ptr<World> world_with(std::string_view flash)
{
    auto world = World::make(robot());
    EXPECT_TRUE(world) << to_sentence(world.error());
    const auto file = config::parse_flash_file(flash, "flash.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    const auto restored = (*world)->restore(*file);
    EXPECT_TRUE(restored) << to_sentence(restored.error());
    return std::move(*world);
}

TEST(WorldFlash, ComesOutAsItWentIn)
{
    const std::string flash = (*World::make(robot()))->flash();
    std::string changed = flash;
    const auto at = changed.find("p_gain = 100", changed.find("[joint.elbow]"));
    ASSERT_NE(at, std::string::npos);
    changed.replace(at, 12, "p_gain = 41");
    const auto world = world_with(changed);
    EXPECT_EQ(world->flash(), changed);
    world->advance(TimePoint{} + 1s);
    EXPECT_EQ(world->flash(), changed);
    EXPECT_NE(world->flash(), flash);
}

TEST(WorldFlash, GivesADeviceTheIdAndTheRateItLastHad)
{
    const auto world =
        world_with("version = 1\n[joint.elbow]\nfamily = \"sam\"\nid = 9\nbit_rate = 115200\nwrites = 2\n");
    EXPECT_EQ(world->find_device("elbow")->id(), 9);
    EXPECT_EQ(world->find_device("elbow")->bit_rate(), 115'200U);
    EXPECT_EQ(world->flash_writes(), 2U);
    EXPECT_EQ(world->find_device("shoulder")->id(), 0) << "as delivered";
}

TEST(WorldFlash, OfAnotherRobotIsRefusedWithItsPlace)
{
    const auto complaint = [](std::string_view text) {
        const auto world = World::make(robot());
        const auto restored = (*world)->restore(*config::parse_flash_file(text, "flash.toml"));
        return restored ? std::string() : to_sentence(restored.error());
    };
    EXPECT_EQ(complaint("version = 1\n[joint.elbo]\nfamily = \"sam\"\n"),
              "flash.toml:2:8: the robot has no joint 'elbo', did you mean elbow?");
    EXPECT_EQ(complaint("version = 1\n[joint.elbow]\nfamily = \"rmd\"\n"),
              "flash.toml:3:10: elbow is a sam in three.toml.");
}

} // namespace
} // namespace sinew::sim::test
