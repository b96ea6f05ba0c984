#include "apps/cli/measured_step.hpp"

#include "apps/cli/joint.hpp"

#include <cmath>

namespace sinew::cli {
namespace {

constexpr Duration least_period = std::chrono::milliseconds(1);

std::expected<std::optional<StepSample>, Error> look(const Driven& driven, Supervised& supervised, TimePoint begin)
{
    if (auto read = supervised.look(); !read)
        return std::unexpected(read.error());
    const auto& state = driven.state;
    if (!state.position_rad)
        return std::nullopt;
    const auto* joint = driven.device.joint;
    return StepSample{.time_s = seconds(state.at - begin),
                      .position_rad = to_joint_position(joint, *state.position_rad),
                      .velocity_rad_s = state.velocity_rad_s ? to_joint_velocity(joint, *state.velocity_rad_s) : NAN,
                      .current_a = state.current_a.optional().value_or(0.0)};
}

void fill_velocities(std::vector<StepSample>& samples)
{
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (!std::isnan(samples[i].velocity_rad_s))
            continue;
        const auto& before = samples[i == 0 ? 0 : i - 1];
        const double time_s = samples[i].time_s - before.time_s;
        samples[i].velocity_rad_s = time_s > 0.0 ? (samples[i].position_rad - before.position_rad) / time_s : 0.0;
    }
}

} // namespace

std::expected<std::vector<StepSample>, Error> measured_step(Session& session, Driven& driven, Supervised& supervised,
                                                            double to_rad, Duration length)
{
    std::vector<StepSample> samples;
    samples.push_back(
        {.position_rad = to_joint_position(driven.device.joint, driven.state.position_rad.value_or(0.0))});
    const TimePoint begin = session.clock().now();
    if (auto sent = supervised.send(move_to_position(driven, to_rad)); !sent)
        return std::unexpected(sent.error());
    TimePoint next = begin;
    while (!interrupted() && session.clock().now() - begin < length) {
        const auto sample = look(driven, supervised, begin);
        if (!sample)
            return interrupted() ? samples
                                 : std::expected<std::vector<StepSample>, Error>(std::unexpected(sample.error()));
        if (*sample && (*sample)->time_s > samples.back().time_s)
            samples.push_back(**sample);
        next = std::max(next + least_period, session.clock().now());
        wait_until(session, next);
    }
    fill_velocities(samples);
    return samples;
}

} // namespace sinew::cli
