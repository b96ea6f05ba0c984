#include "sinew/robot/robot.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/robot/core.hpp"

#include <algorithm>
#include <exception>
#include <fmt/format.h>

namespace sinew::robot {
namespace {

std::unexpected<Error> no_joint(std::span<const Joint> joints, std::string_view joint)
{
    std::vector<std::string_view> names;
    for (const Joint& one : joints)
        names.push_back(one.name());
    return fail(Errc::unknown_name, fmt::format("the robot has no joint '{}'{}", joint, did_you_mean(joint, names)));
}

} // namespace

std::string_view to_word(Stopped::Outcome outcome)
{
    switch (outcome) {
    case Stopped::Outcome::confirmed:
        return "confirmed";
    case Stopped::Outcome::sent:
        return "sent";
    case Stopped::Outcome::failed:
        return "failed";
    }
    return "?";
}

Robot::Robot(std::unique_ptr<Core> core) : core_(std::move(core)) {}
Robot::Robot(Robot&&) noexcept = default;
Robot& Robot::operator=(Robot&&) noexcept = default;

Robot::~Robot()
{
    if (core_ && core_->enabled && std::uncaught_exceptions() > 0)
        (void)core_->stop("an exception");
}

std::expected<Robot, Error> Robot::open(const std::filesystem::path& path, const link::Links& links, link::Clock& clock,
                                        const OpenOptions& options)
{
    auto file = config::read_robot_file(path);
    if (!file)
        return std::unexpected(std::move(file.error()));
    return open(std::move(*file), links, clock, options);
}

std::expected<Robot, Error> Robot::open(config::RobotFile file, const link::Links& links, link::Clock& clock,
                                        const OpenOptions& options)
{
    auto core = Core::make(std::move(file), links, clock, options);
    if (!core)
        return std::unexpected(std::move(core.error()));
    return Robot(std::move(*core));
}

std::expected<void, Error> Robot::enable()
{
    return core_->enable();
}

bool Robot::enabled() const
{
    return core_->enabled;
}

std::expected<void, Error> Robot::cycle()
{
    return core_->cycle();
}

std::expected<void, Error> Robot::run(Duration period, const std::function<void(Robot&)>& each, TimePoint until)
{
    if (period <= Duration{})
        return fail(Errc::bad_argument, "the period of a loop must be above 0");
    return core_->run(
        period,
        [&] {
            if (each)
                each(*this);
            return true;
        },
        until);
}

void Robot::leave() noexcept
{
    core_->leaving = true;
}

std::expected<void, Error> Robot::wait(Duration duration, Duration period)
{
    return run(period, {}, core_->clock->now() + duration);
}

std::expected<void, Error> Robot::home(std::string_view joint, Duration within)
{
    Joint* const found = find(joint);
    return found != nullptr ? core_->home({&found, 1}, within) : no_joint(core_->joints, joint);
}

std::expected<void, Error> Robot::home(Duration within)
{
    std::vector<Joint*> all;
    for (Joint& joint : core_->joints)
        all.push_back(&joint);
    return core_->home(all, within);
}

std::expected<void, Error> Robot::read(Depth depth)
{
    return core_->read(depth);
}

std::vector<Stopped> Robot::stop()
{
    return core_->stop("the program asked for it");
}

void Robot::request_stop() noexcept
{
    core_->request_stop();
}

const Error* Robot::fault() const
{
    return core_->fault ? &*core_->fault : nullptr;
}

std::span<Joint> Robot::joints()
{
    return core_->joints;
}

Joint* Robot::find(std::string_view joint)
{
    const auto at = std::ranges::find(core_->joints, joint, &Joint::name);
    return at == core_->joints.end() ? nullptr : &*at;
}

std::expected<void, Error> Robot::set(std::string_view joint, const Command& command)
{
    Joint* found = find(joint);
    return found != nullptr ? found->set(command) : no_joint(core_->joints, joint);
}

std::expected<State, Error> Robot::state(std::string_view joint)
{
    const Joint* found = find(joint);
    if (found == nullptr)
        return no_joint(core_->joints, joint);
    return found->state();
}

std::span<const Incident> Robot::incidents() const
{
    return core_->incidents.all();
}

std::uint64_t Robot::incidents_dropped() const
{
    return core_->incidents.dropped();
}

std::span<bus::Bus* const> Robot::buses() const
{
    return core_->buses;
}

std::span<const wire::Request> Robot::stop_requests(std::size_t bus) const
{
    return core_->lines.at(bus)->stop_requests();
}

std::span<const wire::Request> Robot::unseen_stop_requests(std::size_t bus) const
{
    return core_->lines.at(bus)->unseen_stop_requests();
}

const config::RobotFile& Robot::file() const
{
    return core_->file;
}

link::Clock& Robot::clock() const
{
    return *core_->clock;
}

} // namespace sinew::robot
