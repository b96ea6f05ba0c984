#include "sinew/robot/identity.hpp"

#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/wire/by_name.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::robot {
namespace {

std::expected<void, Error> compare_sam(std::string_view joint, std::string_view source, const sam::Spec& spec,
                                       const wire::Frame& reply)
{
    const auto said = wire::decode_reply<sam::ReadFirmwareVersion>(reply);
    if (!said)
        return std::unexpected(said.error());
    if (said->message.model_number == spec.model->number)
        return {};
    const auto* model = sam::find_model(said->message.model_number);
    const std::string is = model != nullptr
                               ? std::string(model->name)
                               : fmt::format("model number {}, which nobody documents", said->message.model_number);
    return fail(Errc::bad_reply, fmt::format("{} says that it is {}, and {} says {}; every scale depends on "
                                             "it, so correct its model",
                                             joint, is, source, spec.model->name));
}

std::expected<void, Error> compare_nuri(std::string_view joint, std::string_view source, const nuri::Spec& spec,
                                        const wire::Request& asked, const wire::Frame& reply)
{
    const auto said = wire::decode(*asked.message, wire::Direction::reply, reply, asked.options);
    if (!said)
        return std::unexpected(said.error());
    for (const auto& value : said->values)
        if (value.field->name == "gear_ratio") {
            const double ratio =
                wire::reading(*asked.message, *value.field, spec.profile.line.overrides).physical(value.raw);
            constexpr double half_a_step = 0.05;
            if (std::abs(ratio - spec.profile.external_gear_ratio) > half_a_step)
                return fail(Errc::bad_reply,
                            fmt::format("{} has the gear ratio {:g}, and {} says {:g}; write "
                                        "external_gear_ratio = {:g} under profile_options of its joint",
                                        joint, ratio, source, spec.profile.external_gear_ratio, ratio));
        }
    return {};
}

} // namespace

std::expected<wire::Requests, Error> plan_identity(const DeviceSpec& device)
{
    wire::Requests out;
    if (std::holds_alternative<sam::Spec>(device)) {
        auto request = wire::make_request(id_of(device), sam::ReadFirmwareVersion{}, options_of(device));
        if (!request)
            return std::unexpected(std::move(request.error()));
        out.add(*request);
    }
    if (std::holds_alternative<nuri::Spec>(device)) {
        auto request = wire::make_request(line_of(device), "request-gear-ratio-feedback", id_of(device), {},
                                          options_of(device), response_time_of(device));
        if (request)
            out.add(*request);
    }
    return out;
}

std::expected<void, Error> compare_identity(std::string_view joint, std::string_view source, const DeviceSpec& device,
                                            const wire::Request& asked, const wire::Frame& reply)
{
    if (const auto* spec = std::get_if<sam::Spec>(&device))
        return compare_sam(joint, source, *spec, reply);
    if (const auto* spec = std::get_if<nuri::Spec>(&device))
        return compare_nuri(joint, source, *spec, asked, reply);
    return {};
}

} // namespace sinew::robot
