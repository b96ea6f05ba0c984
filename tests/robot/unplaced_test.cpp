#include "tests/robot/rig.hpp"

#include <algorithm>
#include <gtest/gtest.h>

/// Motors that answer, but no longer say where they are.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

/// A CAN bus on which the answers to one question are lost.
class Deaf final : public link::CanLink
{
public:
    Deaf(std::unique_ptr<link::CanLink> link, const std::optional<std::uint8_t>& lost)
        : link_(std::move(link)), lost_(lost)
    {
    }
    std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) override
    {
        return link_->write(frames);
    }
    std::expected<link::Arrival, Error> read(std::span<wire::Frame> into) override
    {
        auto arrival = link_->read(into);
        if (!arrival)
            return arrival;
        const auto heard = into.first(arrival->count);
        const auto rest = std::ranges::remove_if(heard, [&](const auto& frame) { return frame.data[0] == lost_; });
        arrival->more |= arrival->count == into.size();
        arrival->count -= rest.size();
        return arrival;
    }
    int handle() const override { return link_->handle(); }
    link::LinkState state() const override { return link_->state(); }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override
    {
        return link_->set_bit_rate(bit_rate);
    }

private:
    std::unique_ptr<link::CanLink> link_;
    const std::optional<std::uint8_t>& lost_;
};

constexpr std::uint8_t read_multi_turn_angle = 0x92;

std::string knee(std::string_view safety, std::string_view limits)
{
    return fmt::format("version = 1\n[safety]\n{}\n[bus.r]\nfamily = \"rmd\"\n[joint.knee]\nbus = \"r\"\nid = 1\n"
                       "model = \"MG\"\nprofile = \"rmd-2.35\"\n{}\n",
                       safety, limits);
}

/// A robot of which one question can go without an answer.
struct Unplaced {
    explicit Unplaced(const std::string& text) : simulator(*sim::Simulator::make(file_of(text)))
    {
        link::Links links;
        links.add({.name = "sim",
                   .form = "sim:FILE#BUS",
                   .says = "A bus of this test.",
                   .options = {},
                   .open = [this](const link::Uri& uri, link::Clock&) -> std::expected<link::AnyLink, Error> {
                       auto link = simulator->open(uri.fragment);
                       if (!link)
                           return link;
                       return std::make_unique<Deaf>(std::move(std::get<std::unique_ptr<link::CanLink>>(*link)), lost);
                   }});
        auto opened = Robot::open(file_of(text), links, simulator->clock(), {.simulated = true});
        EXPECT_TRUE(opened.has_value()) << (opened ? "" : to_sentence(opened.error()));
        robot = std::make_unique<Robot>(std::move(*opened));
        EXPECT_EQ(said(robot->enable()), "");
    }
    Joint& knee() { return *robot->find("knee"); }
    std::expected<void, Error> run(const Command& command, Duration time)
    {
        auto set = knee().set(command);
        return set ? robot->wait(time, 10ms) : set;
    }

    std::optional<std::uint8_t> lost;
    std::unique_ptr<sim::Simulator> simulator;
    std::unique_ptr<Robot> robot;
};

constexpr std::string_view limits = "position_min_deg = -90\nposition_max_deg = 90";

TEST(Unplaced, AJointWhosePositionAloneGoesMissingIsStopped)
{
    for (const Command& command :
         {Command{.mode = Mode::hold}, Command{.mode = Mode::velocity, .velocity_rad_s = 0.1}}) {
        Unplaced one(knee("silence_max_s = 0.2", limits));
        ASSERT_EQ(said(one.run(command, 100ms)), "");
        one.lost = read_multi_turn_angle;
        const auto ended = said(one.run(command, 2s));
        EXPECT_NE(ended.find("knee: it answers, but has not told its position for 0.2"), std::string::npos) << ended;
        EXPECT_FALSE(one.robot->enabled());
    }
}

TEST(Unplaced, AJointThatIsFreeOrHasNoLimitsMayKeepItsPlaceToItself)
{
    Unplaced free(knee("silence_max_s = 0.2", limits));
    ASSERT_EQ(said(free.run({.mode = Mode::release}, 100ms)), "");
    free.lost = read_multi_turn_angle;
    EXPECT_EQ(said(free.run({.mode = Mode::release}, 2s)), "");
    EXPECT_EQ(free.knee().overruled(), 0U);

    Unplaced wheel(knee("silence_max_s = 0.2", ""));
    const Command turn{.mode = Mode::velocity, .velocity_rad_s = 1.0};
    ASSERT_EQ(said(wheel.run(turn, 100ms)), "");
    wheel.lost = read_multi_turn_angle;
    EXPECT_EQ(said(wheel.run(turn, 2s)), "");
    EXPECT_EQ(wheel.knee().overruled(), 0U);
}

} // namespace
} // namespace sinew::robot::test
