#pragma once
#include "tests/robot/rig.hpp"

#include <algorithm>
#include <functional>
#include <optional>

/// A robot on CAN buses that lose what a test says.
namespace sinew::robot::test {

struct Losses {
    std::function<bool(const wire::Frame&)> of_sent = [](const wire::Frame&) { return false; };
    std::function<bool(const wire::Frame&)> of_heard = [](const wire::Frame&) { return false; };
    /// What another program says behind each frame.
    std::function<std::optional<wire::Frame>(const wire::Frame&)> others = [](const wire::Frame&) {
        return std::nullopt;
    };
};

class LossyCan final : public link::CanLink
{
public:
    LossyCan(std::unique_ptr<link::CanLink> link, Losses& losses) : link_(std::move(link)), losses_(losses) {}
    std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) override
    {
        for (std::size_t i = 0; i < frames.size(); ++i) {
            if (losses_.of_sent(frames[i]))
                continue;
            const auto written = link_->write(frames.subspan(i, 1));
            if (!written || *written == 0)
                return written ? std::expected<std::size_t, Error>(i) : written;
            if (const auto other = losses_.others(frames[i])) {
                EXPECT_TRUE(link_->write({&*other, 1}));
            }
        }
        return frames.size();
    }
    std::expected<link::Arrival, Error> read(std::span<wire::Frame> into) override
    {
        auto arrival = link_->read(into);
        if (!arrival)
            return arrival;
        const auto rest = std::ranges::remove_if(into.first(arrival->count), losses_.of_heard);
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
    Losses& losses_;
};

struct LossyRobot {
    explicit LossyRobot(const std::string& text) : simulator(*sim::Simulator::make(file_of(text)))
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
                       return std::make_unique<LossyCan>(std::move(std::get<std::unique_ptr<link::CanLink>>(*link)),
                                                         losses);
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
        return set ? robot->wait(time, std::chrono::milliseconds{10}) : set;
    }

    Losses losses;
    std::unique_ptr<sim::Simulator> simulator;
    std::unique_ptr<Robot> robot;
};

} // namespace sinew::robot::test
