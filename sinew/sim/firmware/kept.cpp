#include "sinew/sim/firmware/kept.hpp"

#include "sinew/sim/firmware/nuri_device.hpp"
#include "sinew/sim/firmware/rmd_device.hpp"
#include "sinew/sim/firmware/sam_device.hpp"

namespace sinew::sim {
namespace {

constexpr std::int64_t bit_rate_min = 110;
constexpr std::int64_t bit_rate_max = 4'000'000;

using Sam = SamSettings;
template <auto Place>
consteval KeptRow<Sam> sam_row(std::string_view key, std::int64_t low, std::int64_t high)
{
    return kept<Sam, Place>(key, low, high);
}

/// An instruction of the program as command · 256 + data.
template <std::size_t I>
consteval KeptRow<Sam> instruction(std::string_view key)
{
    return {key, 0, 0xFEFE,
            [](Sam& s, std::int64_t value) {
                s.motion[I] = {static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value & 0xFF)};
            },
            [](const Sam& s) {
                const auto [command, data] = s.motion[I];
                return static_cast<std::int64_t>(command << 8 | data);
            }};
}

constexpr KeptRow<Sam> sam_rows[] = {
    sam_row<[](auto& s) -> auto& { return s.id; }>("id", 0, 254),
    sam_row<[](auto& s) -> auto& { return s.bit_rate; }>("bit_rate", bit_rate_min, bit_rate_max),
    sam_row<[](auto& s) -> auto& { return s.gains.p; }>("p_gain", 0, 254),
    sam_row<[](auto& s) -> auto& { return s.gains.i; }>("i_gain", 0, 254),
    sam_row<[](auto& s) -> auto& { return s.gains.d; }>("d_gain", 0, 254),
    sam_row<[](auto& s) -> auto& { return s.overload; }>("overload", 0, 4095),
    sam_row<[](auto& s) -> auto& { return s.quick_boundary.lower; }>("quick_lower_boundary", 1, 254),
    sam_row<[](auto& s) -> auto& { return s.quick_boundary.upper; }>("quick_upper_boundary", 1, 254),
    sam_row<[](auto& s) -> auto& { return s.standard_boundary.lower; }>("lower_boundary", 1, 254),
    sam_row<[](auto& s) -> auto& { return s.standard_boundary.upper; }>("upper_boundary", 1, 254),
    sam_row<[](auto& s) -> auto& { return s.response_level; }>("response_level", 0, 2),
    sam_row<[](auto& s) -> auto& { return s.reverse; }>("reverse", 0, 1),
    sam_row<[](auto& s) -> auto& { return s.avg_torque; }>("avg_torque", 0, 2000),
    sam_row<[](auto& s) -> auto& { return s.motion_count; }>("motion_count", 0, 8),
    instruction<0>("motion_1"),
    instruction<1>("motion_2"),
    instruction<2>("motion_3"),
    instruction<3>("motion_4"),
    instruction<4>("motion_5"),
    instruction<5>("motion_6"),
    instruction<6>("motion_7"),
    instruction<7>("motion_8"),
};

using Nuri = NuriSettings;
template <auto Place>
consteval KeptRow<Nuri> nuri_row(std::string_view key, std::int64_t low, std::int64_t high)
{
    return kept<Nuri, Place>(key, low, high);
}

constexpr KeptRow<Nuri> nuri_rows[] = {
    nuri_row<[](auto& s) -> auto& { return s.id; }>("id", 0, 254),
    nuri_row<[](auto& s) -> auto& { return s.bit_rate; }>("bit_rate", bit_rate_min, bit_rate_max),
    nuri_row<[](auto& s) -> auto& { return s.response_time; }>("response_time", 0, 254),
    nuri_row<[](auto& s) -> auto& { return s.gear_ratio; }>("gear_ratio", 1, 65533),
    nuri_row<[](auto& s) -> auto& { return s.rated_speed; }>("rated_speed", 0, 65533),
    nuri_row<[](auto& s) -> auto& { return s.resolution; }>("resolution", 0, 65533),
    nuri_row<[](auto& s) -> auto& { return s.on; }>("control_on", 0, 1),
    nuri_row<[](auto& s) -> auto& { return s.relative; }>("relative", 0, 1),
    nuri_row<[](auto& s) -> auto& { return s.inverted; }>("inverted", 0, 1),
    nuri_row<[](auto& s) -> auto& { return s.position.kp; }>("position_kp", 1, 254),
    nuri_row<[](auto& s) -> auto& { return s.position.ki; }>("position_ki", 0, 254),
    nuri_row<[](auto& s) -> auto& { return s.position.kd; }>("position_kd", 0, 254),
    nuri_row<[](auto& s) -> auto& { return s.position.rated_current; }>("position_rated_current", 1, 255),
    nuri_row<[](auto& s) -> auto& { return s.speed.kp; }>("speed_kp", 1, 254),
    nuri_row<[](auto& s) -> auto& { return s.speed.ki; }>("speed_ki", 0, 254),
    nuri_row<[](auto& s) -> auto& { return s.speed.kd; }>("speed_kd", 0, 254),
    nuri_row<[](auto& s) -> auto& { return s.speed.rated_current; }>("speed_rated_current", 1, 255),
};

using Rmd = RmdMemory;
template <auto Place>
consteval KeptRow<Rmd> rmd_row(std::string_view key, std::int64_t low, std::int64_t high)
{
    return kept<Rmd, Place>(key, low, high);
}

/// The data bytes of a parameter as one number, the first one lowest.
template <rmd::ParameterId Id>
consteval KeptRow<Rmd> parameter(std::string_view key)
{
    return {key, 0, static_cast<std::int64_t>(parameter_bits(Id, ~std::uint64_t{0})),
            [](Rmd& s, std::int64_t value) { s.parameter(Id) = static_cast<std::uint64_t>(value); },
            [](const Rmd& s) { return static_cast<std::int64_t>(s.parameter(Id)); }};
}

constexpr KeptRow<Rmd> rmd_rows[] = {
    parameter<rmd::ParameterId::angle_pid>("angle_pid"),
    parameter<rmd::ParameterId::speed_pid>("speed_pid"),
    parameter<rmd::ParameterId::current_pid>("current_pid"),
    parameter<rmd::ParameterId::max_torque_current>("max_torque_current"),
    parameter<rmd::ParameterId::max_speed>("max_speed"),
    parameter<rmd::ParameterId::max_angle_low>("max_angle_low"),
    parameter<rmd::ParameterId::max_angle_high>("max_angle_high"),
    parameter<rmd::ParameterId::current_ramp>("current_ramp"),
    parameter<rmd::ParameterId::speed_ramp>("speed_ramp"),
    rmd_row<[](auto& s) -> auto& { return s.pid.angle_kp; }>("angle_kp", 0, 255),
    rmd_row<[](auto& s) -> auto& { return s.pid.angle_ki; }>("angle_ki", 0, 255),
    rmd_row<[](auto& s) -> auto& { return s.pid.speed_kp; }>("speed_kp", 0, 255),
    rmd_row<[](auto& s) -> auto& { return s.pid.speed_ki; }>("speed_ki", 0, 255),
    rmd_row<[](auto& s) -> auto& { return s.pid.current_kp; }>("current_kp", 0, 255),
    rmd_row<[](auto& s) -> auto& { return s.pid.current_ki; }>("current_ki", 0, 255),
    rmd_row<[](auto& s) -> auto& { return s.encoder_offset; }>("encoder_offset", 0, 65535),
};

} // namespace

std::vector<KeptValue> SamDevice::kept() const
{
    return kept_values<Sam>(sam_rows, stored_.kept(), stored_.writes());
}

std::expected<void, Error> SamDevice::restore(const config::FlashFile& file, const config::FlashJoint& joint)
{
    const auto read = read_kept<Sam>(file, joint, sam_rows, stored_.kept());
    if (!read)
        return std::unexpected(read.error());
    const Sam& set = read->settings;
    if (set.quick_boundary.lower >= set.quick_boundary.upper ||
        set.standard_boundary.lower >= set.standard_boundary.upper)
        return config::fail_at(file, joint.at,
                               fmt::format("a lower boundary of {} is not below the upper one.", joint.name));
    stored_.restore(set, read->writes);
    power_cycle();
    return {};
}

std::vector<KeptValue> NuriDevice::kept() const
{
    return kept_values<Nuri>(nuri_rows, stored_.kept(), stored_.writes());
}

std::expected<void, Error> NuriDevice::restore(const config::FlashFile& file, const config::FlashJoint& joint)
{
    const auto read = read_kept<Nuri>(file, joint, nuri_rows, stored_.kept());
    if (!read)
        return std::unexpected(read.error());
    stored_.restore(read->settings, read->writes);
    power_cycle();
    return {};
}

std::vector<KeptValue> RmdDevice::kept() const
{
    return kept_values<Rmd>(rmd_rows, rom_, flash_writes_);
}

std::expected<void, Error> RmdDevice::restore(const config::FlashFile& file, const config::FlashJoint& joint)
{
    const auto read = read_kept<Rmd>(file, joint, rmd_rows, rom_);
    if (!read)
        return std::unexpected(read.error());
    rom_ = read->settings;
    flash_writes_ = read->writes;
    power_cycle();
    return {};
}

} // namespace sinew::sim
