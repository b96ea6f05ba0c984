#include "apps/cli/step_response.hpp"

#include "apps/cli/joint.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/family/drivers.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/sim/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using namespace std::chrono_literals;

constexpr Duration sample_time = 1ms;
constexpr double settled_share = 0.02;

/// The time of the simulator, which looks at a joint every millisecond while somebody waits: during exchanges too.
class LookingClock final : public link::Clock
{
public:
    LookingClock(link::Clock& clock, const config::Joint& joint, const sim::Plant& plant)
        : clock_(clock), joint_(joint), plant_(plant)
    {
    }

    TimePoint now() const override { return clock_.now(); }
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override
    {
        clock_.wait(handles, std::min(deadline, next_));
        while (clock_.now() >= next_) {
            look();
            next_ += sample_time;
        }
    }
    /// From now on.
    void begin(std::size_t samples)
    {
        samples_.reserve(samples);
        begin_ = next_ = now();
        look();
        next_ += sample_time;
    }
    std::vector<StepSample>& samples() { return samples_; }

private:
    void look()
    {
        samples_.push_back({.time_s = seconds(next_ - begin_),
                            .position_rad = to_joint_position(&joint_, plant_.position_rad()),
                            .velocity_rad_s = to_joint_velocity(&joint_, plant_.velocity_rad_s()),
                            .current_a = plant_.current_a()});
    }

    link::Clock& clock_;
    const config::Joint& joint_;
    const sim::Plant& plant_;
    std::vector<StepSample> samples_;
    TimePoint begin_{};
    TimePoint next_ = TimePoint::max();
};

std::expected<Device, Error> joint_of(const config::RobotFile& file, const std::string& name)
{
    auto robot = resolve(file);
    if (!robot)
        return std::unexpected(robot.error());
    std::vector<std::string_view> names;
    for (auto& joint : robot->joints) {
        names.push_back(joint.joint->name);
        if (joint.joint->name == name)
            return Device{.name = name,
                          .link = joint.bus->name,
                          .family = joint.family,
                          .id = sinew::id_of(joint.device),
                          .spec = std::move(joint.device),
                          .joint = joint.joint,
                          // The caller keeps the file.
                          .file = std::shared_ptr<const config::RobotFile>(std::shared_ptr<void>(), &file)};
    }
    return fail(Errc::unknown_name, fmt::format("{} has no joint '{}'{}", file.path, name, suggestion(name, names)));
}

void start_at(config::RobotFile& file, const std::string& name, double joint_rad)
{
    const auto joint = std::ranges::find(file.joints, name, &config::Joint::name);
    if (joint == file.joints.end())
        return;
    std::erase_if(joint->sim, [](const config::Setting& setting) { return setting.key == "start_rad"; });
    joint->sim.push_back({"start_rad", to_actuator_position(&*joint, joint_rad), joint->at});
}

std::expected<void, Error> set_gains(Driven& driven, const std::array<std::uint8_t, 3>& gains)
{
    const auto send = [&](const auto& message) -> std::expected<void, Error> {
        auto request = driven.bus->request(driven.device.id, message);
        if (!request)
            return std::unexpected(request.error());
        request->answered = driven.device.answers(*request->message);
        const auto answer = ask(*driven.bus, *request);
        return answer ? std::expected<void, Error>{} : std::unexpected(answer.error());
    };
    if (auto sent = send(sam::SetRuntimePdGain{.p_gain = gains[0], .d_gain = gains[2]}); !sent)
        return sent;
    return send(sam::SetRuntimeIGain{.i_gain = gains[1]});
}

std::expected<Device, Error> checked(const config::RobotFile& file, const StepRequest& request)
{
    auto device = joint_of(file, request.joint);
    if (!device)
        return device;
    for (const auto& position : {std::optional(request.to_rad), request.from_rad})
        if (position)
            if (auto fine = check_limits(*device, *position, std::nullopt); !fine)
                return std::unexpected(fine.error());
    if (request.gains && device->family->name != "sam")
        return fail(Errc::unsupported, fmt::format("--gains are those of a SAM; {} is a device of the family {}",
                                                   device->name, device->family->name));
    return device;
}

/// Until the next whole millisecond, the tick of devices and plants.
void wait_for_tick(link::Clock& clock)
{
    const TimePoint tick = std::chrono::ceil<std::chrono::milliseconds>(clock.now());
    while (clock.now() < tick)
        clock.wait({}, tick);
}

} // namespace

std::expected<std::vector<StepSample>, Error> step_response(config::RobotFile file, const StepRequest& request)
{
    if (request.from_rad)
        start_at(file, request.joint, *request.from_rad);
    auto device = checked(file, request);
    if (!device)
        return std::unexpected(device.error());
    const auto simulator = sim::Simulator::make(file);
    if (!simulator)
        return std::unexpected(simulator.error());
    auto link = (*simulator)->open(device->link);
    if (!link)
        return std::unexpected(link.error());
    sim::Plant& plant = (*simulator)->world().find_device(request.joint)->plant();
    LookingClock clock((*simulator)->clock(), *device->joint, plant);
    bus::Bus bus(device->link, std::move(*link), clock, *device->family->protocol);
    bus.set_device(device->id,
                   {.line = &device->line(), .options = device->options(), .response_time = device->response_time()});
    auto driver = make_driver(*device->spec);
    Driven driven{.device = std::move(*device), .bus = &bus, .driver = std::move(driver)};

    plant.jam(true);
    if (auto read = read_state(driven, actuator::Depth::full); !read)
        return std::unexpected(read.error());
    if (auto set = set_up(driven); !set)
        return std::unexpected(set.error());
    if (request.gains)
        if (auto set = set_gains(driven, *request.gains); !set)
            return std::unexpected(set.error());
    const auto requests = plan(driven, move_to_position(driven, request.to_rad));
    if (!requests)
        return std::unexpected(requests.error());
    wait_for_tick(clock);
    plant.jam(false);
    const TimePoint end = clock.now() + request.length;
    clock.begin(static_cast<std::size_t>(request.length / sample_time) + 2);
    if (auto sent = carry_out(driven, *requests); !sent)
        return std::unexpected(sent.error());
    while (clock.now() < end)
        clock.wait({}, end);
    return std::move(clock.samples());
}

StepFigures figures_of(const std::vector<StepSample>& samples, double target_rad)
{
    const double start = samples.front().position_rad;
    const double step = target_rad - start;
    const auto share = [&](const StepSample& sample) { return (sample.position_rad - start) / step; };
    StepFigures out;
    std::optional<double> tenth, nine_tenths;
    std::optional<double> settled;
    for (const auto& sample : samples) {
        const double done = share(sample);
        if (!tenth && done >= 0.1)
            tenth = sample.time_s;
        if (!nine_tenths && done >= 0.9)
            nine_tenths = sample.time_s;
        out.overshoot = std::max(out.overshoot, done - 1.0);
        out.peak_current_a = std::max(out.peak_current_a, std::abs(sample.current_a));
        if (std::abs(done - 1.0) > settled_share)
            settled.reset();
        else if (!settled)
            settled = sample.time_s;
    }
    if (nine_tenths)
        out.rise_time_s = *nine_tenths - *tenth;
    out.settling_time_s = settled;
    const std::size_t last = std::max<std::size_t>(1, samples.size() / 10);
    for (auto sample = samples.end() - static_cast<std::ptrdiff_t>(last); sample != samples.end(); ++sample)
        out.steady_error_rad += (target_rad - sample->position_rad) / static_cast<double>(last);
    return out;
}

} // namespace sinew::cli
