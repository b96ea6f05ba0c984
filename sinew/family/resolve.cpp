#include "sinew/family/apply.hpp"
#include "sinew/family/families.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/options.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>
#include <vector>

namespace sinew {
namespace {

/// Which of the words that describe a device is wrong, and why.
struct Problem {
    enum class Part : std::uint8_t { model, profile, id } part;
    std::string what;
};

/// A device in words.
struct Wish {
    std::string_view model, profile;
    std::int64_t id = 0;
};

// ---- what is special about each family ----

struct SamRules {
    using Spec = sam::Spec;
    using Model = sam::Model;
    static const Model* find_model(std::string_view name) { return sam::find_model(name); }
    static const Model* default_model() { return nullptr; }
    static std::string_view line_of(const Model&) { return sam::profiles().front().line.name; }
    static auto profiles() { return sam::profiles(); }
    static auto profile_options() { return sam::profile_options(); }
    static auto device_options() { return sam::device_options(); }
    static void named(Spec&) {}
    static void between(Spec& spec) { spec.device.response_level = spec.profile.response_level; }
    static void finish(Spec& spec) { spec.profile.line.options = spec.profile.options(); }
    static auto runtime_options() { return sam::runtime_options(); }
    static std::string_view wrong_runtime(const Spec& spec)
    {
        const bool one_alone = spec.runtime.p_gain.has_value() != spec.runtime.d_gain.has_value();
        return one_alone ? "p_gain and d_gain travel together; give both." : "";
    }
};

struct NuriRules {
    using Spec = nuri::Spec;
    using Model = nuri::Model;
    static const Model* find_model(std::string_view name) { return nuri::find_model(name); }
    static const Model* default_model() { return &nuri::models().front(); }
    static std::string_view line_of(const Model& model) { return model.line; }
    static auto profiles() { return nuri::profiles(); }
    static auto profile_options() { return nuri::profile_options(); }
    static auto device_options() { return nuri::device_options(); }
    static void named(Spec&) {}
    static void between(Spec&) {}
    /// Without mode 0x0F the line is the manual's list less its last entry (N08).
    static void finish(Spec& spec)
    {
        auto& messages = spec.profile.line.messages;
        if (!spec.profile.control_direction && messages.back() == &wire::info_of<nuri::SetControlDirection>)
            messages = messages.first(messages.size() - 1);
    }
};

struct RmdRules {
    using Spec = rmd::Spec;
    using Model = rmd::Model;
    static const Model* find_model(std::string_view name) { return rmd::find_model(name); }
    static const Model* default_model() { return &rmd::models().front(); }
    static std::string_view line_of(const Model&) { return rmd::profiles().front().line.name; }
    static auto profiles() { return rmd::profiles(); }
    static auto profile_options() { return rmd::profile_options(); }
    static auto device_options() { return rmd::device_options(); }
    static void named(Spec& spec) { spec.profile.max_speed_confirmed = true; }
    static void between(Spec&) {}
    static void finish(Spec& spec) { spec = rmd::make_spec(*spec.model, spec.profile, spec.id, spec.device); }
    static auto runtime_options() { return rmd::runtime_options(); }
    static std::string_view wrong_runtime(const Spec& spec)
    {
        const rmd::Runtime& own = spec.runtime;
        const auto has = [&](std::string_view message) { return spec.profile.line.find(message) != nullptr; };
        if (own.acceleration_rad_s2 && !has("write-acceleration-ram"))
            return "this firmware line has no message for an acceleration.";
        const bool at_once = has("write-pid-ram");
        std::size_t loops = 0;
        for (const auto* loop : {&own.angle, &own.speed, &own.current}) {
            loops += loop->given() ? 1U : 0U;
            if (loop->given() && !at_once && !has("write-parameter-ram"))
                return "this firmware line has no message for gains.";
            if (loop->given() && (!loop->kp || !loop->ki || at_once == loop->kd.has_value()))
                return at_once ? "the gains of this firmware line are kp and ki of each loop."
                               : "kp, ki and kd of a loop travel together; give all three.";
        }
        return at_once && loops != 0 && loops != 3 ? "the gains of all three loops travel together; give all." : "";
    }
};

/// Calls `f` with the rules of a family.
template <class F>
auto with_rules(const Family& family, F f)
{
    if (family.name == "sam")
        return f(SamRules{});
    if (family.name == "nuri")
        return f(NuriRules{});
    return f(RmdRules{});
}

/// Model, profile and id; the options have their defaults and nothing is worked out yet.
template <class Rules>
std::expected<typename Rules::Spec, Problem> choose(Rules, const Family& family, const Wish& wish)
{
    const auto models = names_of(family.models, [](const ModelInfo& one) { return one.name; });
    const auto* model = wish.model.empty() ? Rules::default_model() : Rules::find_model(wish.model);
    if (!model && wish.model.empty())
        return std::unexpected(
            Problem{Problem::Part::model, fmt::format("{} needs a model, because every scale depends on it: {}.",
                                                      family.name, fmt::join(models, ", "))});
    if (!model)
        return std::unexpected(Problem{Problem::Part::model, no_such(family.name, "model", wish.model, models)});

    const std::string_view line = wish.profile.empty() ? Rules::line_of(*model) : wish.profile;
    const auto lines = Rules::profiles();
    const auto profile = std::ranges::find_if(lines, [&](const auto& one) { return one.line.name == line; });
    if (profile == lines.end())
        return std::unexpected(
            Problem{Problem::Part::profile,
                    no_such(family.name, "profile", line,
                            names_of(family.profiles, [](const wire::Profile* one) { return one->name; }))});

    if (!family.ids.contains(wish.id))
        return std::unexpected(Problem{Problem::Part::id, fmt::format("{} has ids from {} to {}, not {}.", family.name,
                                                                      family.ids.low, family.ids.high, wish.id)});

    typename Rules::Spec spec{.model = model, .profile = *profile, .id = static_cast<int>(wish.id)};
    if (!wish.profile.empty())
        Rules::named(spec);
    return spec;
}

config::Mark place_of(const config::Joint& joint, Problem::Part part)
{
    if (part == Problem::Part::model && joint.model)
        return joint.model->at;
    if (part == Problem::Part::profile && joint.profile)
        return joint.profile->at;
    return part == Problem::Part::id ? joint.id.at : joint.at;
}

/// What the device is set to after every power-on.
template <class Rules>
std::expected<void, Error> apply_runtime(Rules, const config::RobotFile& file, const config::Joint& joint,
                                         typename Rules::Spec& spec)
{
    if (joint.runtime.empty())
        return {};
    const config::Mark at = joint.runtime.front().at;
    if constexpr (requires { Rules::runtime_options(); }) {
        if (auto done = apply(file, joint.runtime, Rules::runtime_options(), spec.profile.line.name, "run-time setting",
                              spec.runtime);
            !done)
            return done;
        const std::string_view wrong = Rules::wrong_runtime(spec);
        return wrong.empty() ? std::expected<void, Error>{} : config::fail_at(file, at, std::string(wrong));
    } else {
        return config::fail_at(file, at, "a device of this family keeps every setting; it has none to be set anew.");
    }
}

std::expected<DeviceSpec, Error> device_of(const config::RobotFile& file, const config::Joint& joint,
                                           const config::Bus& bus, const Family& family)
{
    return with_rules(family, [&]<class Rules>(Rules rules) -> std::expected<DeviceSpec, Error> {
        const Wish wish{joint.model ? std::string_view{joint.model->value} : std::string_view{},
                        joint.profile ? std::string_view{joint.profile->value} : std::string_view{}, joint.id.value};
        auto spec = choose(rules, family, wish);
        if (!spec)
            return config::fail_at(file, place_of(joint, spec.error().part), std::move(spec.error().what));
        spec->device.bit_rate =
            bus.bit_rate ? static_cast<std::uint32_t>(bus.bit_rate->value) : family.default_bit_rate;
        if (auto done = apply(file, joint.options, Rules::profile_options(), spec->profile.line.name, "profile option",
                              spec->profile);
            !done)
            return std::unexpected(std::move(done.error()));
        Rules::between(*spec);
        if (auto done = apply(file, joint.sim, Rules::device_options(), family.name, "sim option", spec->device); !done)
            return std::unexpected(std::move(done.error()));
        Rules::finish(*spec);
        if (auto done = apply_runtime(rules, file, joint, *spec); !done)
            return std::unexpected(std::move(done.error()));
        return DeviceSpec{std::move(*spec)};
    });
}

std::expected<const Family*, Error> family_of_bus(const config::RobotFile& file, const config::Bus& bus)
{
    const Family* family = find_family(bus.family.value);
    if (!family) {
        const auto names = names_of(families(), [](const Family* one) { return one->name; });
        return config::fail_at(file, bus.family.at, no_such("sinew", "family", bus.family.value, names));
    }
    const auto is_given = [&](const BitRate& rate) { return rate.bps == bus.bit_rate->value; };
    if (bus.bit_rate && std::ranges::none_of(family->bit_rates, is_given)) {
        std::vector<std::uint32_t> rates;
        for (const BitRate& rate : family->bit_rates)
            rates.push_back(rate.bps);
        return config::fail_at(file, bus.bit_rate->at,
                               fmt::format("{} has no bit rate {}. It has {}.", family->name, bus.bit_rate->value,
                                           fmt::join(rates, ", ")));
    }
    return family;
}

std::expected<void, Error> check_ids(const config::RobotFile& file)
{
    for (std::size_t i = 0; i < file.joints.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const config::Joint &joint = file.joints[i], &earlier = file.joints[j];
            if (joint.bus.value == earlier.bus.value && joint.id.value == earlier.id.value)
                return config::fail_at(file, joint.id.at,
                                       fmt::format("id {} on bus {} belongs to joint {} already (line {}).",
                                                   joint.id.value, joint.bus.value, earlier.name, earlier.id.at.line));
        }
    return {};
}

} // namespace

std::expected<DeviceSpec, Error> make_spec(const Family& family, std::string_view model, std::string_view profile,
                                           int id)
{
    return with_rules(family, [&]<class Rules>(Rules rules) -> std::expected<DeviceSpec, Error> {
        auto spec = choose(rules, family, Wish{model, profile, id});
        if (!spec) {
            const bool id_is_bad = spec.error().part == Problem::Part::id;
            auto error = fail(id_is_bad ? Errc::bad_id : Errc::unknown_name, std::move(spec.error().what));
            if (id_is_bad) {
                error.error().value = id;
                error.error().low = family.ids.low;
                error.error().high = family.ids.high;
            }
            return error;
        }
        spec->device.bit_rate = family.default_bit_rate;
        Rules::between(*spec);
        Rules::finish(*spec);
        return DeviceSpec{std::move(*spec)};
    });
}

std::expected<ResolvedRobot, Error> resolve(const config::RobotFile& file)
{
    for (const config::Bus& bus : file.buses)
        if (auto family = family_of_bus(file, bus); !family)
            return std::unexpected(std::move(family.error()));
    ResolvedRobot robot;
    for (const config::Joint& joint : file.joints) {
        const config::Bus* bus = file.find_bus(joint.bus.value);
        if (!bus)
            return config::fail_at(file, joint.bus.at, fmt::format("there is no bus {}.", joint.bus.value));
        const Family& family = *find_family(bus->family.value);
        auto device = device_of(file, joint, *bus, family);
        if (!device)
            return std::unexpected(std::move(device.error()));
        robot.joints.push_back({&joint, bus, &family, std::move(*device)});
    }
    if (auto fine = check_ids(file); !fine)
        return std::unexpected(std::move(fine.error()));
    return robot;
}

} // namespace sinew
