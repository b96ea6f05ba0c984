#include "sinew/family/rmd/driver.hpp"
#include "sinew/family/rmd/messages.hpp"

#include <array>

namespace sinew::rmd {
namespace {

struct Loop {
    std::string_view kp, ki;
    ParameterId parameter;
    const LoopGains Runtime::* gains;
};
constexpr std::array<Loop, 3> loops = {{{"angle_kp", "angle_ki", ParameterId::angle_pid, &Runtime::angle},
                                        {"speed_kp", "speed_ki", ParameterId::speed_pid, &Runtime::speed},
                                        {"current_kp", "current_ki", ParameterId::current_pid, &Runtime::current}}};

bool differs(const std::optional<std::uint16_t>& own, std::optional<std::int64_t> said)
{
    return own && said && *own != *said;
}

} // namespace

void Driver::notice(std::string_view what)
{
    reset_ = what;
    track_.forget();
}

void Driver::notice_lost_turns()
{
    has_lost_turns_ = true;
    notice("its angle has lost whole turns");
}

void Driver::compare_settings(const wire::MessageInfo& message, const wire::Values& values)
{
    if (!set_)
        return;
    const Runtime& own = spec_.runtime;
    bool gone = false;
    if (message.name() == "read-acceleration" && own.acceleration_rad_s2)
        gone = values.find("acceleration") != to_raw(*own.acceleration_rad_s2, 1.0);
    for (const Loop& loop : loops) {
        const LoopGains& gains = own.*loop.gains;
        if (message.name() == "read-pid")
            gone = gone || differs(gains.kp, values.find(loop.kp)) || differs(gains.ki, values.find(loop.ki));
        if (message.name() == "read-parameter" && values.find("param_id") == static_cast<std::int64_t>(loop.parameter))
            gone = gone || differs(gains.kp, values.find("kp")) || differs(gains.ki, values.find("ki")) ||
                   differs(gains.kd, values.find("kd"));
    }
    if (gone)
        notice("its acceleration or gains are not those that were set");
}

std::expected<wire::Requests, Error> Driver::plan_settings()
{
    const Runtime& own = spec_.runtime;
    wire::Requests out;
    std::expected<void, Error> added;
    if (own.acceleration_rad_s2)
        added = add(out, "write-acceleration-ram", {{"acceleration", to_raw(*own.acceleration_rad_s2, 1.0)}});
    const auto number = [](const std::optional<std::uint16_t>& gain) { return std::int64_t{gain.value_or(0)}; };
    if (added && own.angle.given() && has("write-pid-ram"))
        added = add(out, "write-pid-ram",
                    {{"angle_kp", number(own.angle.kp)},
                     {"angle_ki", number(own.angle.ki)},
                     {"speed_kp", number(own.speed.kp)},
                     {"speed_ki", number(own.speed.ki)},
                     {"current_kp", number(own.current.kp)},
                     {"current_ki", number(own.current.ki)}});
    for (const Loop& loop : loops) {
        const LoopGains& gains = own.*loop.gains;
        if (added && gains.given() && !has("write-pid-ram"))
            added = add(out, "write-parameter-ram",
                        {{"param_id", static_cast<std::int64_t>(loop.parameter)},
                         {"kp", number(gains.kp)},
                         {"ki", number(gains.ki)},
                         {"kd", number(gains.kd)}});
    }
    if (!added)
        return std::unexpected(std::move(added.error()));
    set_ = !out.empty();
    reset_ = {};
    return out;
}

std::expected<wire::Requests, Error> Driver::plan_reset_check()
{
    const Runtime& own = spec_.runtime;
    wire::Requests out;
    // The angle by way of its turns, and on LK lines whether it is on.
    auto added = add(out, "read-status2");
    if (added)
        added = add(out, "read-multi-turn-angle");
    if (added && can_.measures_enabled)
        added = add(out, "read-status1");
    if (added && set_ && own.acceleration_rad_s2)
        added = add(out, "read-acceleration");
    const bool together = has("read-pid");
    if (added && set_ && together && own.angle.given())
        added = add(out, "read-pid");
    for (const Loop& loop : loops)
        if (added && set_ && !together && (own.*loop.gains).given())
            added = add(out, "read-parameter", {{"param_id", static_cast<std::int64_t>(loop.parameter)}});
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

} // namespace sinew::rmd
