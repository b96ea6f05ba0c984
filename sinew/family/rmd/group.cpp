#include "sinew/family/rmd/group.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/family/rmd/messages.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>

namespace sinew::rmd {
namespace {

constexpr int most_id = 4;          // L1143
constexpr double a_per_lsb = 0.016; // L1127: 2000 is 32 A
constexpr std::int64_t largest = 2000;
constexpr double printed_full_scale_a = 32.0;

std::expected<void, Error> can_join(const GroupMember& member)
{
    const Spec& spec = member.driver->spec();
    if (spec.id > most_id)
        return actuator::refuse(Errc::unsupported, spec.id, "a torque group reaches the ids 1 to 4 only");
    if (!spec.profile.line.has(wire::info_of<MultiMotorTorque>))
        return actuator::refuse(Errc::unsupported, spec.id,
                                "its firmware line has no message for a torque group; command it alone");
    const double full_scale = spec.iq_a().value_or(0.0) * 2048.0;
    if (full_scale < printed_full_scale_a - a_per_lsb)
        return actuator::refuse(Errc::unsupported, spec.id,
                                "the scale of a torque group is documented for motors of 32 A at full scale only; "
                                "command it alone");
    return {};
}

std::expected<std::int16_t, Error> raw_of(const GroupMember& member)
{
    if (auto fine = can_join(member); !fine)
        return std::unexpected(std::move(fine.error()));
    const auto current = member.driver->current_of(member.command);
    if (!current)
        return std::unexpected(current.error());
    // Towards zero, but for the noise of the conversion.
    const double raw = std::trunc(*current / a_per_lsb + std::copysign(1e-6, *current));
    if (std::abs(raw) > static_cast<double>(largest))
        return actuator::refuse(Errc::out_of_range, member.driver->spec().id,
                                fmt::format("{:g} A is more than the {:g} A that a torque group can carry", *current,
                                            static_cast<double>(largest) * a_per_lsb));
    return static_cast<std::int16_t>(raw);
}

} // namespace

std::expected<wire::Requests, Error> plan_group(std::span<const GroupMember> members)
{
    if (members.empty())
        return fail(Errc::bad_argument, "a torque group needs a motor");
    std::array<std::int16_t, most_id> raw{};
    std::array<bool, most_id> taken{};
    wire::Requests out;
    for (const GroupMember& member : members) {
        const auto current = raw_of(member);
        if (!current)
            return std::unexpected(current.error());
        const int id = member.driver->spec().id;
        const auto place = static_cast<std::size_t>(id - 1);
        if (taken[place])
            return actuator::refuse(Errc::bad_argument, id, "it is in the group twice");
        taken[place] = true;
        raw[place] = *current;
    }
    for (const GroupMember& member : members)
        if (auto run = member.driver->add_run(out); !run)
            return std::unexpected(std::move(run.error()));
    const Spec& first = members.front().driver->spec();
    auto frame =
        wire::make_request(-1, MultiMotorTorque{.iq_1 = raw[0], .iq_2 = raw[1], .iq_3 = raw[2], .iq_4 = raw[3]},
                           first.profile.options(), response_time);
    if (!frame)
        return std::unexpected(frame.error());
    frame->replies = static_cast<std::uint8_t>(members.size());
    out.add(*frame);
    return out;
}

} // namespace sinew::rmd
