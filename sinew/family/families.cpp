#include "sinew/family/families.hpp"

#include "sinew/family/assumed.hpp"
#include "sinew/family/nuri/framing.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/options.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/family/sam/framing.hpp"
#include "sinew/family/sam/messages.hpp"

#include <array>

namespace sinew {
namespace {

/// The bit rates that the words of a baud code name.
template <std::size_t N>
consteval std::array<BitRate, N> rates_of(const wire::Label (&codes)[N])
{
    std::array<BitRate, N> rates{};
    for (std::size_t i = 0; i < N; ++i) {
        rates[i].code = static_cast<int>(codes[i].value);
        for (const char digit : codes[i].name)
            rates[i].bps = rates[i].bps * 10 + static_cast<std::uint32_t>(digit - '0');
    }
    return rates;
}

constexpr auto sam_rates = rates_of(sam::baud_codes);
constexpr auto nuri_rates = rates_of(nuri::baud_codes);
/// The manual fixes 1 Mbps and has no code for it (R36); the vendor's tool has 500 kbps as well (field notes 1).
constexpr BitRate rmd_rates[] = {{-1, 1'000'000}, {-1, 500'000}};

/// L56: steps of 100 us, 254 at most, 1 as delivered.
constexpr ResponseTime nuri_response{std::chrono::microseconds{100}, std::chrono::microseconds{25'400}};
constexpr ResponseTime rmd_response{rmd::response_time, rmd::response_time};

/// Views of one family's tables, made once.
template <class Profile, class Model, class DeviceOptions>
struct Tables {
    std::vector<const wire::Profile*> profiles;
    std::vector<ModelInfo> models;
    std::vector<OptionInfo> profile_options, sim_options;

    Tables(std::span<const Profile> lines, std::span<const Model> products,
           std::span<const Option<Profile>> profile_keys, std::span<const Option<DeviceOptions>> sim_keys)
    {
        for (const Profile& one : lines)
            profiles.push_back(&one.line);
        for (const Model& one : products)
            models.push_back({one.name, describe(one)});
        for (const auto& one : profile_keys)
            profile_options.push_back({one.key, one.says});
        for (const auto& one : sim_keys)
            sim_options.push_back({one.key, one.says});
    }

    static std::string_view describe(const Model& model)
    {
        if constexpr (std::is_same_v<Model, sam::Model>)
            return model.encoder ? "encoder class" : "potentiometer class";
        else
            return model.says;
    }
};

template <class T>
Family with_tables(Family family, const T& tables)
{
    family.profiles = tables.profiles;
    family.models = tables.models;
    family.profile_options = tables.profile_options;
    family.sim_options = tables.sim_options;
    return family;
}

const Family& sam_family()
{
    static const Tables<sam::Profile, sam::Model, sam::DeviceOptions> tables{
        sam::profiles(), sam::models(), sam::profile_options(), sam::device_options()};
    static const Family family =
        with_tables({.name = "sam",
                     .title = "SAM servos (UART, RS-485)",
                     .protocol = &sam::protocol(),
                     .ids = {0, 254},
                     .broadcast_id = 31,
                     .bit_rates = sam_rates,
                     .default_bit_rate = 1'500'000,
                     .response_time = {assumed_sam_response_typical, assumed_sam_response_most}},
                    tables);
    return family;
}

const Family& nuri_family()
{
    static const Tables<nuri::Profile, nuri::Model, nuri::DeviceOptions> tables{
        nuri::profiles(), nuri::models(), nuri::profile_options(), nuri::device_options()};
    static const Family family = with_tables({.name = "nuri",
                                              .title = "Nuri smart actuators (RS-485)",
                                              .protocol = &nuri::protocol(),
                                              .ids = {0, 254},
                                              .broadcast_id = 255,
                                              .bit_rates = nuri_rates,
                                              .default_bit_rate = 9600,
                                              .response_time = nuri_response},
                                             tables);
    return family;
}

const Family& rmd_family()
{
    static const Tables<rmd::Profile, rmd::Model, rmd::DeviceOptions> tables{
        rmd::profiles(), rmd::models(), rmd::profile_options(), rmd::device_options()};
    static const Family family = with_tables({.name = "rmd",
                                              .title = "RMD motors (CAN)",
                                              .can = true,
                                              .protocol = &rmd::protocol(),
                                              .ids = rmd::ids,
                                              .default_id = 1,
                                              .bit_rates = rmd_rates,
                                              .default_bit_rate = 1'000'000,
                                              .response_time = rmd_response},
                                             tables);
    return family;
}

template <class... Cases>
struct Overloaded : Cases... {
    using Cases::operator()...;
};

} // namespace

const wire::Profile* Family::find_profile(std::string_view profile) const
{
    for (const wire::Profile* one : profiles)
        if (one->name == profile)
            return one;
    return nullptr;
}

std::span<const Family* const> families()
{
    static const std::array<const Family*, 3> all{&sam_family(), &nuri_family(), &rmd_family()};
    return all;
}

const Family* find_family(std::string_view name)
{
    for (const Family* family : families())
        if (family->name == name)
            return family;
    return nullptr;
}

const Family& family_of(const DeviceSpec& device)
{
    return *families()[device.index()];
}

int id_of(const DeviceSpec& device)
{
    return std::visit([](const auto& spec) { return spec.id; }, device);
}

std::string_view model_of(const DeviceSpec& device)
{
    return std::visit([](const auto& spec) { return spec.model->name; }, device);
}

const wire::Profile& line_of(const DeviceSpec& device)
{
    return std::visit([](const auto& spec) -> const wire::Profile& { return spec.profile.line; }, device);
}

wire::Options options_of(const DeviceSpec& device)
{
    return std::visit([](const auto& spec) { return spec.profile.options(); }, device);
}

std::span<const wire::Override> overrides_of(const DeviceSpec& device)
{
    return std::visit(
        Overloaded{[](const sam::Spec& spec) { return spec.model->overrides; },
                   [](const nuri::Spec&) { return std::span<const wire::Override>{}; },
                   [](const rmd::Spec& spec) { return std::span(spec.overrides).first(spec.override_count); }},
        device);
}

Duration response_time_of(const DeviceSpec& device)
{
    if (const auto* spec = std::get_if<nuri::Spec>(&device))
        return spec->profile.response_time();
    return family_of(device).response_time.most;
}

bool offers(const DeviceSpec& device, const wire::MessageInfo& message)
{
    const auto* sam = std::get_if<sam::Spec>(&device);
    return sam == nullptr || sam::offers(*sam->model, message);
}

bool answers(const DeviceSpec& device, const wire::MessageInfo& message)
{
    const auto* sam = std::get_if<sam::Spec>(&device);
    return message.reply.exists() && (sam == nullptr || sam->profile.answers(message));
}

} // namespace sinew
