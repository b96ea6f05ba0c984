#include "sinew/family/options.hpp"

#include "sinew/base/units.hpp"

namespace sinew {
namespace {

constexpr double any_turn_rad = 1.0e6;
constexpr std::string_view start_says = "rad at power-on";
constexpr std::string_view supply_says = "volts, 0 to 100";
constexpr std::string_view temperature_says = "degC, -40 to 150";
constexpr std::string_view bit_rate_says = "bits per second, 110 to 4000000";

template <class T>
bool set_whole(std::optional<T>& target, const OptionValue& value, wire::Range range)
{
    const auto* number = std::get_if<std::int64_t>(&value);
    const bool good = number && range.contains(*number);
    if (good)
        target = static_cast<T>(*number);
    return good;
}

} // namespace

namespace sam {
namespace {

constexpr Word<BoundaryOrder> boundary_orders[] = {{"upper_first", BoundaryOrder::upper_then_lower},
                                                   {"lower_first", BoundaryOrder::lower_then_upper}};
constexpr Word<PortBits> port_bits[] = {{"ch_led", PortBits::ch_led}, {"do_low", PortBits::do_low}};
constexpr Word<WheelReply> wheel_replies[] = {{"rotation_position", WheelReply::rotation_position},
                                              {"id_id", WheelReply::id_id}};
constexpr Word<BoundaryStorage> boundary_storages[] = {{"separate", BoundaryStorage::separate},
                                                       {"shared_raw", BoundaryStorage::shared_raw},
                                                       {"shared_angle", BoundaryStorage::shared_angle}};
constexpr Word<OverloadResume> overload_resumes[] = {{"auto", OverloadResume::automatic},
                                                     {"stay_passive", OverloadResume::stay_passive}};
constexpr Word<MotionWrap> motion_wraps[] = {{"loop", MotionWrap::loop}, {"stop", MotionWrap::stop}};
constexpr Word<MotionRepeat> motion_repeats[] = {{"total", MotionRepeat::total},
                                                 {"additional", MotionRepeat::additional}};
constexpr Word<BaudSwitch> baud_switches[] = {{"after_reply", BaudSwitch::after_reply},
                                              {"at_power_on", BaudSwitch::at_power_on}};
constexpr Word<DriveModeReply> drive_mode_replies[] = {{"new_level", DriveModeReply::new_level},
                                                       {"old_level", DriveModeReply::old_level}};

constexpr std::string_view level_says = "0 (answers reads), 1 (answers everything) or 2 (answers nothing)";

constexpr Option<Profile> profile_table[] = {
    choice<&Profile::quick_boundary_order, boundary_orders>("quick_boundary_order", "upper_first or lower_first"),
    choice<&Profile::quick_port_bits, port_bits>("quick_port_bits", "ch_led or do_low"),
    choice<&Profile::wheel_reply, wheel_replies>("wheel_reply", "rotation_position or id_id"),
    flag<&Profile::clockwise_positive>("clockwise_positive"),
    whole<&Profile::response_level, 0, 2>("response_level", level_says),
    flag<&Profile::ping_is_read>("ping_is_read"),
    flag<&Profile::quick_id_strict>("quick_id_strict"),
    flag<&Profile::i_gain_strict>("i_gain_strict"),
};

constexpr Option<DeviceOptions> device_table[] = {
    whole<&DeviceOptions::bit_rate, 110, 4'000'000>("bit_rate", bit_rate_says),
    whole<&DeviceOptions::response_level, 0, 2>("response_level", level_says),
    flag<&DeviceOptions::reverse>("reverse"),
    flag<&DeviceOptions::reverse_works>("reverse_works"),
    flag<&DeviceOptions::ping_ignores_id>("ping_ignores_id"),
    flag<&DeviceOptions::brake_broadcast_reply>("brake_broadcast_reply"),
    flag<&DeviceOptions::offset_control_works>("offset_control_works"),
    choice<&DeviceOptions::boundary_storage, boundary_storages>("boundary_storage",
                                                                "separate, shared_raw or shared_angle"),
    choice<&DeviceOptions::overload_resume, overload_resumes>("overload_resume", "auto or stay_passive"),
    choice<&DeviceOptions::motion_wrap, motion_wraps>("motion_wrap", "loop or stop"),
    choice<&DeviceOptions::motion_repeat, motion_repeats>("motion_repeat", "total or additional"),
    choice<&DeviceOptions::baud_switch, baud_switches>("baud_switch", "after_reply or at_power_on"),
    choice<&DeviceOptions::drive_mode_reply, drive_mode_replies>("drive_mode_reply", "new_level or old_level"),
    number<&DeviceOptions::fixed_overload_a, 0.0, 100.0>("fixed_overload_a", "amperes, 0 to 100; 0 for never"),
    whole<&DeviceOptions::flash_writes_max, 0, 1'000'000'000>("flash_writes_max", "a count; 0 for no end"),
    flag<&DeviceOptions::repeats_checked>("repeats_checked"),
    flag<&DeviceOptions::position_ends_modes>("position_ends_modes"),
    number<&DeviceOptions::wheel_middle_duty, 0.24, 0.41>("wheel_middle_duty", "a share of 1, 0.24 to 0.41"),
    flag<&DeviceOptions::wheel_obeys_boundaries>("wheel_obeys_boundaries"),
    number<&DeviceOptions::overheat_hysteresis_k, 0.0, 60.0>("overheat_hysteresis_k", "kelvins, 0 to 60"),
    whole<&DeviceOptions::port_at_power_on, 0, 15>("port_at_power_on", "0 to 15"),
    flag<&DeviceOptions::motion_runs_when_written>("motion_runs_when_written"),
    number<&DeviceOptions::supply_v, 0.0, 100.0>("supply_v", supply_says),
    number<&DeviceOptions::temperature_c, -40.0, 150.0>("temperature_c", temperature_says),
    number<&DeviceOptions::external_v, 0.0, external_max_v>("external_v", "volts, 0 to 5.5"),
    number<&DeviceOptions::start_rad, -any_turn_rad, any_turn_rad>("start_rad", start_says),
};

constexpr std::string_view gain_says = "as the servo counts it, 0 to 254";

template <auto Gain, int Low>
bool set_gain(Runtime& runtime, const OptionValue& value)
{
    return set_whole(runtime.*Gain, value, {Low, 254});
}

constexpr Option<Runtime> runtime_table[] = {
    {"p_gain", "as the servo counts it, 1 to 254", set_gain<&Runtime::p_gain, 1>},
    {"d_gain", gain_says, set_gain<&Runtime::d_gain, 0>},
    {"i_gain", gain_says, set_gain<&Runtime::i_gain, 0>},
};

} // namespace

std::span<const Option<Profile>> profile_options()
{
    return profile_table;
}
std::span<const Option<DeviceOptions>> device_options()
{
    return device_table;
}
std::span<const Option<Runtime>> runtime_options()
{
    return runtime_table;
}

} // namespace sam

namespace nuri {
namespace {

constexpr Word<PositionFeedbackLimit> feedback_limits[] = {{"clamp", PositionFeedbackLimit::clamp},
                                                           {"wrap", PositionFeedbackLimit::wrap}};

constexpr Word<PositionReset> position_resets[] = {{"here_is_zero", PositionReset::here_is_zero},
                                                   {"go_to_zero", PositionReset::go_to_zero}};
constexpr Word<BusSwitch> bus_switches[] = {{"at_once", BusSwitch::at_once}, {"at_power_on", BusSwitch::at_power_on}};
constexpr Word<RelativeBase> relative_bases[] = {{"position", RelativeBase::position},
                                                 {"target", RelativeBase::target}};

constexpr Option<Profile> profile_table[] = {
    flag<&Profile::ccw_positive>("ccw_positive"),
    choice<&Profile::position_feedback_limit, feedback_limits>("position_feedback_limit", "clamp or wrap"),
    flag<&Profile::control_direction>("control_direction"),
    number<&Profile::external_gear_ratio, 0.1, 6553.3>("external_gear_ratio", "a ratio, 0.1 to 6553.3"),
    number<&Profile::response_time_us, 0.0, 25'400.0>("response_time_us", "microseconds, 0 to 25400"),
};

constexpr Option<DeviceOptions> device_table[] = {
    whole<&DeviceOptions::bit_rate, 110, 4'000'000>("bit_rate", bit_rate_says),
    flag<&DeviceOptions::settings_persist>("settings_persist"),
    flag<&DeviceOptions::control_direction_works>("control_direction_works"),
    flag<&DeviceOptions::off_keeps_target>("off_keeps_target"),
    choice<&DeviceOptions::relative_base, relative_bases>("relative_base", "position or target"),
    choice<&DeviceOptions::position_reset, position_resets>("position_reset", "here_is_zero or go_to_zero"),
    choice<&DeviceOptions::bus_switch, bus_switches>("bus_switch", "at_once or at_power_on"),
    flag<&DeviceOptions::reset_keeps_bus>("reset_keeps_bus"),
    number<&DeviceOptions::rated_current_a, 0.0, 25.5>("rated_current_a", "amperes, 0 to 25.5"),
    number<&DeviceOptions::supply_v, 0.0, 100.0>("supply_v", supply_says),
    number<&DeviceOptions::start_rad, -any_turn_rad, any_turn_rad>("start_rad", start_says),
};

} // namespace

std::span<const Option<Profile>> profile_options()
{
    return profile_table;
}
std::span<const Option<DeviceOptions>> device_options()
{
    return device_table;
}

} // namespace nuri

namespace rmd {
namespace {

constexpr Word<ClearErrorReply> clear_error_replies[] = {{"0x9A", ClearErrorReply::as_printed_9a},
                                                         {"0x9B", ClearErrorReply::own_9b}};
constexpr Word<IncrementBase> increment_bases[] = {{"target", IncrementBase::target},
                                                   {"position", IncrementBase::position}};
constexpr Word<OffsetEffect> offset_effects[] = {{"at_once", OffsetEffect::at_once},
                                                 {"at_power_on", OffsetEffect::at_power_on}};

/// Naming the scale confirms it (R01).
bool set_max_speed_scale(Profile& profile, const OptionValue& value)
{
    const auto given = as_number(value);
    if (!given || (*given != 0.01 && *given != 1.0))
        return false;
    profile.max_speed_lsb_dps = *given;
    profile.max_speed_confirmed = true;
    return true;
}

bool set_full_scale(Profile& profile, const OptionValue& value)
{
    const auto given = as_number(value);
    const bool good = given && *given > 0.0 && *given <= 1000.0;
    if (good)
        profile.torque_current_full_scale_a = given;
    return good;
}

bool set_torque_constant(Profile& profile, const OptionValue& value)
{
    const auto given = as_number(value);
    const bool good = given && *given > 0.0 && *given <= 1000.0;
    if (good)
        profile.torque_constant_nm_per_a = given;
    return good;
}

constexpr Option<Profile> profile_table[] = {
    {"max_speed_lsb_dps", "0.01 or 1", set_max_speed_scale},
    choice<&Profile::clear_error_reply, clear_error_replies>("clear_error_reply", "\"0x9A\" or \"0x9B\""),
    {"torque_current_full_scale_a", "amperes at 2048, above 0", set_full_scale},
    whole<&Profile::encoder_bits, 12, 18>("encoder_bits", "12 to 18"),
    flag<&Profile::off_requires_run>("off_requires_run"),
    number<&Profile::gear_ratio, 0.001, 10'000.0>("gear_ratio", "turns of the counted shaft for one of the output, "
                                                                "0.001 to 10000"),
    {"torque_constant_nm_per_a", "newton metres per ampere, above 0", set_torque_constant},
};

constexpr std::string_view acceleration_says = "at the output, above 0";
constexpr std::string_view gain_says = "as the motor counts it, 0 to 65535";

template <double Unit>
bool set_acceleration(Runtime& runtime, const OptionValue& value)
{
    const auto given = as_number(value);
    const bool good = given && *given > 0.0 && *given <= 1.0e7;
    if (good)
        runtime.acceleration_rad_s2 = *given * Unit;
    return good;
}

template <auto Loop, auto Gain>
bool set_gain(Runtime& runtime, const OptionValue& value)
{
    return set_whole((runtime.*Loop).*Gain, value, {0, 65535});
}

constexpr Option<Runtime> runtime_table[] = {
    {"acceleration_rad_s2", acceleration_says, set_acceleration<1.0>},
    {"acceleration_deg_s2", acceleration_says, set_acceleration<units::rad_per_deg>},
    {"angle_kp", gain_says, set_gain<&Runtime::angle, &LoopGains::kp>},
    {"angle_ki", gain_says, set_gain<&Runtime::angle, &LoopGains::ki>},
    {"angle_kd", gain_says, set_gain<&Runtime::angle, &LoopGains::kd>},
    {"speed_kp", gain_says, set_gain<&Runtime::speed, &LoopGains::kp>},
    {"speed_ki", gain_says, set_gain<&Runtime::speed, &LoopGains::ki>},
    {"speed_kd", gain_says, set_gain<&Runtime::speed, &LoopGains::kd>},
    {"current_kp", gain_says, set_gain<&Runtime::current, &LoopGains::kp>},
    {"current_ki", gain_says, set_gain<&Runtime::current, &LoopGains::ki>},
    {"current_kd", gain_says, set_gain<&Runtime::current, &LoopGains::kd>},
};

constexpr Option<DeviceOptions> device_table[] = {
    whole<&DeviceOptions::bit_rate, 10'000, 4'000'000>("bit_rate", "bits per second, 10000 to 4000000"),
    choice<&DeviceOptions::increment_base, increment_bases>("increment_base", "target or position"),
    choice<&DeviceOptions::encoder_offset_effect, offset_effects>("encoder_offset_effect", "at_once or at_power_on"),
    flag<&DeviceOptions::multi_motor>("multi_motor"),
    flag<&DeviceOptions::stops_on_fault>("stops_on_fault"),
    flag<&DeviceOptions::reply_lag>("reply_lag"),
    flag<&DeviceOptions::turns_kept>("turns_kept"),
    flag<&DeviceOptions::echoes_unknown>("echoes_unknown"),
    number<&DeviceOptions::supply_v, 0.0, 100.0>("supply_v", supply_says),
    number<&DeviceOptions::low_voltage_v, 0.0, 100.0>("low_voltage_v", supply_says),
    number<&DeviceOptions::over_voltage_v, 0.0, 100.0>("over_voltage_v", supply_says),
    number<&DeviceOptions::temperature_c, -40.0, 150.0>("temperature_c", temperature_says),
    number<&DeviceOptions::temperature_limit_c, -40.0, 150.0>("temperature_limit_c", temperature_says),
    number<&DeviceOptions::max_speed_dps, 0.0, 100'000.0>("max_speed_dps", "degrees per second, 0 to 100000"),
    number<&DeviceOptions::max_acceleration_dps_s, 0.0, 1.0e7>("max_acceleration_dps_s",
                                                               "degrees per second squared, 0 to 10000000"),
    number<&DeviceOptions::max_angle_deg, 0.0, 2.0e7>("max_angle_deg", "degrees, 0 to 20000000; 0 for no limit"),
    number<&DeviceOptions::start_rad, -any_turn_rad, any_turn_rad>("start_rad", start_says),
};

} // namespace

std::span<const Option<Profile>> profile_options()
{
    return profile_table;
}
std::span<const Option<DeviceOptions>> device_options()
{
    return device_table;
}
std::span<const Option<Runtime>> runtime_options()
{
    return runtime_table;
}

} // namespace rmd

} // namespace sinew
