#include "sinew/robot/load.hpp"

#include "sinew/family/families.hpp"
#include "sinew/robot/line.hpp"
#include "sinew/wire/values.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>

namespace sinew::robot {
namespace {

std::vector<wire::Request> requests_of(std::span<const Load::Part> parts)
{
    std::vector<wire::Request> out;
    for (const auto& part : parts)
        out.push_back(part.request);
    return out;
}

/// So that no place that it knows is old.
constexpr Duration longer_than_planning = std::chrono::hours{1};

/// An answer of zeros, or of what is nearest to them.
std::expected<wire::Frame, Error> any_reply(const wire::Request& asked)
{
    wire::Values values;
    for (const auto& value : wire::value_fields(asked.message->reply, asked.options)) {
        const auto range = wire::allowed(*value.field);
        values.add(*value.field, std::clamp<std::int64_t>(0, range.low, range.high));
    }
    return wire::encode(*asked.message, wire::Direction::reply, asked.id, values, asked.options);
}

} // namespace

void settle(actuator::Driver& driver, State& state, TimePoint at)
{
    const auto read = driver.plan_read(Depth::motion);
    if (!read)
        return;
    for (const auto& asked : read->all())
        if (const auto reply = any_reply(asked))
            (void)driver.absorb(asked, *reply, at, state);
}

/// The joints of a line without a bus.
class LoadOfLine
{
public:
    LoadOfLine(Line& line, const bus::Line& wire) : line_(line), wire_(wire) {}

    Load load()
    {
        for (Joint* joint : line_.joints_)
            settle(*joint->driver_, joint->raw_, joint->now() + longer_than_planning);
        for (Joint* joint : line_.joints_) {
            move(*joint);
            command_otherwise(*joint);
            probe(*joint);
            for (const auto beside : Line::all_beside)
                if (const auto planned = Line::plan(*joint, beside))
                    add(out_.most, *joint, planned->all());
        }
        stop();
        return std::move(out_);
    }

private:
    static void add(std::vector<Load::Part>& to, const Joint& joint, std::span<const wire::Request> requests)
    {
        for (const auto& request : requests)
            to.push_back({joint.name(), request});
    }

    /// What the bus asks by itself, before it trusts a line of bare answers again.
    void probe(const Joint& joint)
    {
        const auto& protocol = *joint.family().protocol;
        if (const auto asked = protocol.probe(id_of(joint.device())); asked && protocol.bare_replies())
            add(out_.most, joint, {&*asked, 1});
    }

    static std::expected<wire::Requests, Error> plan(Joint& joint, const Command& command)
    {
        joint.command_ = command;
        joint.fresh_ = true;
        return joint.plan({}, 0.0);
    }

    /// Some firmware lines want a speed beside a position.
    void move(Joint& joint)
    {
        const auto& can = joint.can_;
        Command command{.mode = Mode::position, .position_rad = 0.0};
        if (can.position_low_rad && can.position_high_rad)
            command.position_rad = (*can.position_low_rad + *can.position_high_rad) / 2;
        auto planned = plan(joint, command);
        if (!planned) {
            command.velocity_rad_s = 1.0;
            planned = plan(joint, command);
        }
        if (!planned) {
            out_.notes.push_back(fmt::format("{}: {}", joint.name(), to_sentence(planned.error())));
            return;
        }
        add(out_.cycle, joint, planned->all());
        add(out_.most, joint, planned->all());
    }

    /// Whatever the driver takes of these.
    void command_otherwise(Joint& joint)
    {
        for (const Command& command :
             {Command{.mode = Mode::release}, Command{.mode = Mode::brake},
              Command{.mode = Mode::velocity, .velocity_rad_s = 0.1},
              Command{.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = 0.1}, Command{.mode = Mode::hold}})
            if (const auto planned = plan(joint, command))
                add(out_.most, joint, planned->all());
        if (const auto idle = joint.driver_->plan_idle()) // before a hold of what is blocked
            add(out_.most, joint, idle->all());
    }

    /// What a joint is told first must be undone later, so the order is that of the longest.
    void stop()
    {
        std::vector<std::vector<Load::Part>> all;
        std::vector<std::vector<Load::Part>> longest(line_.joints_.size());
        using enum Joint::Places;
        for (const auto& [mode, places] :
             {std::pair{Mode::release, latest}, {Mode::hold, none}, {Mode::hold, latest}}) {
            for (Joint* joint : line_.joints_)
                joint->command_ = {.mode = mode};
            std::vector<wire::Request> requests;
            line_.collect_stop(requests, Line::Whom::all, places, TimePoint{});
            all.push_back(named(requests));
            for (std::size_t i = 0; i < longest.size(); ++i) {
                std::vector<Load::Part> own;
                std::ranges::copy_if(all.back(), std::back_inserter(own),
                                     [&](const auto& part) { return part.joint == line_.joints_[i]->name(); });
                longest[i] = std::max(longest[i], own, is_shorter());
            }
        }
        // Some may move while others were let go; then nothing goes to all of them.
        std::vector<Load::Part> mixed;
        for (const auto& one : longest)
            mixed.insert(mixed.end(), one.begin(), one.end());
        all.push_back(std::move(mixed));
        out_.stop = *std::ranges::max_element(all, is_shorter());
    }

    std::function<bool(const std::vector<Load::Part>&, const std::vector<Load::Part>&)> is_shorter() const
    {
        return [this](const auto& one, const auto& other) {
            return bus::predict_stop(wire_, {}, requests_of(one)).ends <
                   bus::predict_stop(wire_, {}, requests_of(other)).ends;
        };
    }

    std::vector<Load::Part> named(std::span<const wire::Request> requests) const
    {
        std::vector<Load::Part> out;
        for (const auto& request : requests) {
            const auto whose =
                std::ranges::find(line_.joints_, request.id, [](const Joint* joint) { return id_of(joint->device()); });
            out.push_back({whose != line_.joints_.end() ? (*whose)->name() : "all", request});
        }
        return out;
    }

    Line& line_;
    const bus::Line& wire_;
    Load out_;
};

std::expected<Load, Error> load_of(const config::RobotFile& file, std::string_view bus, const bus::Line& line)
{
    const auto resolved = resolve(file);
    if (!resolved)
        return std::unexpected(resolved.error());
    const link::RealClock clock;
    Incidents incidents;
    std::vector<Joint> joints;
    joints.reserve(resolved->joints.size());
    std::vector<Joint*> own;
    for (const auto& joint : resolved->joints)
        if (joint.bus->name == bus)
            own.push_back(&joints.emplace_back(joint, file, clock, incidents));
    const Pause none;
    Line of_bus(nullptr, {}, true, none);
    of_bus.set_joints(std::move(own));
    return LoadOfLine(of_bus, line).load();
}

} // namespace sinew::robot
