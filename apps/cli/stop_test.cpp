#include "apps/cli/stop_devices.hpp"
#include "sinew/family/broadcast.hpp"
#include "sinew/family/drivers.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

/// A simulated robot in virtual time, and what went out on the bus of its four Nuris.
class StopTest : public testing::Test
{
protected:
    StopTest()
    {
        Words words;
        words.add("--robot", "robots/demo.toml"); // tests run in the folder of the sources
        words.add("--sim", "");
        all_ = *targets(words);
        for (const auto& device : all_)
            (*session_.bus_of(device))->set_tap([&, nuri = device.family->name == "nuri"](const bus::Tapped& tapped) {
                if (tapped.direction == wire::Direction::request)
                    sent_.push_back({nuri, {tapped.bytes.begin(), tapped.bytes.end()}});
            });
    }

    struct Sent {
        bool to_nuri = false;
        std::vector<std::uint8_t> bytes;
    };

    static bool is(const Sent& one, const wire::Request& request)
    {
        return std::ranges::equal(one.bytes, request.frame.bytes());
    }
    std::vector<Sent> to_nuris() const
    {
        std::vector<Sent> out;
        std::ranges::copy_if(sent_, std::back_inserter(out), &Sent::to_nuri);
        return out;
    }
    long count(const wire::Request& request) const
    {
        return std::ranges::count_if(sent_, [&](const Sent& one) { return one.to_nuri && is(one, request); });
    }
    const Device& device(std::string_view name) const { return *std::ranges::find(all_, name, &Device::name); }

    Session session_;
    std::vector<Device> all_;
    std::vector<Sent> sent_;
    wire::Request everybody_ = stop_of_all(*find_family("nuri"))->request;
};

TEST_F(StopTest, OfAWholeRobotGoesToAllOfALineAtOnceBeforeItGoesToEach)
{
    const auto done = stop_devices(session_, all_, true, false);
    EXPECT_EQ(done.size(), all_.size());
    for (const auto& one : done)
        EXPECT_TRUE(one.outcome && one.outcome->confirmed) << one.name;
    EXPECT_TRUE(is(to_nuris().front(), everybody_));
    EXPECT_EQ(count(everybody_), 1);
}

TEST_F(StopTest, OfSomeJointsAndOneThatHoldsLeaveTheOthersOfTheLineAlone)
{
    stop_devices(session_, {&device("waist_yaw"), 1}, false, false);
    stop_devices(session_, all_, true, true);
    EXPECT_EQ(count(everybody_), 0);
}

TEST_F(StopTest, TellsEveryJointBeforeItLooksAtOne)
{
    stop_devices(session_, all_, true, false);
    auto next = sent_.begin();
    for (const auto& one : all_) {
        next += is(*next, everybody_);
        const auto release = make_driver(*one.spec)->plan({.mode = actuator::Mode::release}, {});
        for (const auto& request : release->all())
            EXPECT_TRUE(is(*next++, request)) << one.name;
    }
}

} // namespace
} // namespace sinew::cli
