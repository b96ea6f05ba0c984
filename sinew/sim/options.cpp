#include "sinew/sim/options.hpp"

#include "sinew/base/units.hpp"
#include "sinew/family/apply.hpp"

namespace sinew::sim {
namespace {

constexpr double much = 1e6; // more than any actuator has
constexpr double some = 1e-9;

constexpr std::string_view above_0 = "a number above 0";
constexpr std::string_view from_0 = "a number from 0 on";

constexpr Option<WorldOptions> world_table[] = {
    whole<&WorldOptions::seed, 0, std::numeric_limits<std::int64_t>::max()>("seed", "a whole number from 0 on"),
};

constexpr Word<Collision> collisions[] = {{"garble", Collision::garble}, {"and", Collision::wired_and}};

constexpr Option<BusOptions> bus_table[] = {
    number<&BusOptions::supply_v, 0.0, 100.0>("supply_v", "volts, 0 to 100"),
    number<&BusOptions::supply_ohm, 0.0, 100.0>("supply_ohm", "ohms, 0 to 100"),
    flag<&BusOptions::echo>("echo"),
    flag<&BusOptions::half_duplex>("half_duplex"),
    choice<&BusOptions::collision, collisions>("collision", "garble or and"),
    number<&BusOptions::usb_latency_s, 0.0, 1.0>("usb_latency_s", "seconds, 0 to 1"),
};

/// An angle in degrees, for those who write it so.
template <auto Member>
consteval Option<PlantParameters> degrees(std::string_view key)
{
    return {key, "degrees, -36000000 to 36000000", [](PlantParameters& target, const OptionValue& value) {
                const auto given = as_number(value);
                const bool good = given && std::abs(*given) <= 3.6e7;
                if (good)
                    target.*Member = units::rad(*given);
                return good;
            }};
}

using P = PlantParameters;
constexpr Option<P> plant_table[] = {
    number<&P::winding_ohm, some, much>("winding_ohm", above_0),
    number<&P::torque_constant_nm_per_a, some, much>("torque_constant_nm_per_a", above_0),
    number<&P::rotor_inertia_kg_m2, some, much>("rotor_inertia_kg_m2", above_0),
    number<&P::gear_ratio, some, much>("gear_ratio", above_0),
    number<&P::gear_efficiency, 0.01, 1.0>("gear_efficiency", "a number from 0.01 to 1"),
    number<&P::viscous_friction_nm_s_per_rad, 0.0, much>("viscous_friction_nm_s_per_rad", from_0),
    number<&P::coulomb_friction_nm, 0.0, much>("coulomb_friction_nm", from_0),
    number<&P::static_friction_nm, 0.0, much>("static_friction_nm", from_0),
    number<&P::load_inertia_kg_m2, 0.0, much>("load_inertia_kg_m2", from_0),
    number<&P::external_torque_nm, -much, much>("external_torque_nm", "newton metres"),
    number<&P::gravity_torque_nm, 0.0, much>("gravity_torque_nm", from_0),
    number<&P::gravity_zero_rad, -much, much>("gravity_zero_rad", "radians"),
    degrees<&P::gravity_zero_rad>("gravity_zero_deg"),
    number<&P::stop_min_rad, -much, much>("stop_min_rad", "radians"),
    degrees<&P::stop_min_rad>("stop_min_deg"),
    number<&P::stop_max_rad, -much, much>("stop_max_rad", "radians"),
    degrees<&P::stop_max_rad>("stop_max_deg"),
    number<&P::winding_heat_capacity_j_per_k, 0.1, much>("winding_heat_capacity_j_per_k", "a number from 0.1 on"),
    number<&P::winding_to_case_k_per_w, 0.001, much>("winding_to_case_k_per_w", "a number from 0.001 on"),
    number<&P::case_heat_capacity_j_per_k, 0.1, much>("case_heat_capacity_j_per_k", "a number from 0.1 on"),
    number<&P::case_to_ambient_k_per_w, 0.001, much>("case_to_ambient_k_per_w", "a number from 0.001 on"),
    number<&P::ambient_c, -100.0, 200.0>("ambient_c", "degrees Celsius, -100 to 200"),
};

} // namespace

std::span<const Option<WorldOptions>> world_options()
{
    return world_table;
}

std::span<const Option<BusOptions>> bus_options()
{
    return bus_table;
}

std::span<const Option<PlantParameters>> plant_options()
{
    return plant_table;
}

std::expected<WorldOptions, Error> world_options_of(const config::RobotFile& file)
{
    WorldOptions out;
    if (auto done = apply(file, file.sim, world_options(), "sim", "option", out); !done)
        return std::unexpected(std::move(done.error()));
    return out;
}

std::expected<BusOptions, Error> bus_options_of(const config::RobotFile& file, const config::Bus& bus)
{
    BusOptions out;
    if (auto done = apply(file, bus.sim, bus_options(), "a bus", "sim option", out); !done)
        return std::unexpected(std::move(done.error()));
    const Family* family = find_family(bus.family.value);
    const bool is_serial =
        out.echo || out.half_duplex || out.collision != Collision::by_wire || out.usb_latency_s > 0.0;
    if (family != nullptr && family->can && is_serial)
        return config::fail_at(file, bus.sim.front().at,
                               "echo, half_duplex, collision and usb_latency_s are for serial buses; this one is CAN.");
    return out;
}

std::expected<void, Error> check_half_duplex(const config::RobotFile& file, const ResolvedJoint& joint)
{
    const auto* sam = std::get_if<sam::Spec>(&joint.device);
    if (sam == nullptr || sam->model->encoder)
        return {};
    return config::fail_at(
        file, joint.joint->at,
        fmt::format("a {} has no RS-485, but its bus is half_duplex; the encoder models have it.", sam->model->name));
}

std::expected<PlantParameters, Error> plant_of(const config::RobotFile& file, const config::Joint& joint,
                                               const PlantParameters& derived)
{
    PlantParameters out = derived;
    if (joint.plant.empty())
        return out;
    if (auto done = apply(file, joint.plant, plant_options(), "a plant", "option", out); !done)
        return std::unexpected(std::move(done.error()));
    const config::Mark at = joint.plant.front().at;
    if (out.stop_min_rad >= out.stop_max_rad)
        return config::fail_at(file, at, "the lower hard stop must be below the upper one.");
    if (out.static_friction_nm < out.coulomb_friction_nm)
        return config::fail_at(file, at,
                               fmt::format("static_friction_nm ({:g}) must not be below coulomb_friction_nm ({:g}).",
                                           out.static_friction_nm, out.coulomb_friction_nm));
    // Heat goes on by steps of a tick: what settles faster than ten of them would swing.
    const double quickest_s =
        std::min(out.winding_heat_capacity_j_per_k * out.winding_to_case_k_per_w,
                 out.case_heat_capacity_j_per_k * std::min(out.winding_to_case_k_per_w, out.case_to_ambient_k_per_w));
    if (quickest_s < 10.0 * tick_s)
        return config::fail_at(
            file, at,
            fmt::format("heat capacity times thermal resistance gives {:g} s; 0.01 s is the least.", quickest_s));
    return out;
}

} // namespace sinew::sim
