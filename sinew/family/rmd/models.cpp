#include "sinew/family/rmd/models.hpp"

#include "sinew/family/lookup.hpp"
#include "sinew/family/rmd/lines.hpp"

namespace sinew::rmd {
namespace {

constexpr double full_scale_raw = 2048.0;

constexpr Model products[] = {
    {.name = "RMD", .says = "any motor; torque current stays in raw units", .source = "R13: no table of models"},
    {.name = "MF",
     .iq = Iq::current,
     .torque_current_full_scale_a = 16.5,
     .says = "torque current 16.5 A at 2048",
     .source = "L777, L798"},
    {.name = "MG",
     .iq = Iq::current,
     .torque_current_full_scale_a = 33.0,
     .says = "torque current 33 A at 2048",
     .source = "L98, L641, L836; printed as 32 A in L777 (R11)"},
    {.name = "MS",
     .iq = Iq::power,
     .says = "power instead of torque current; the only class with torque-open-loop",
     .source = "field notes 1: LK V2.35 reply iq"},
    {.name = "RMD-L",
     .iq = Iq::current,
     .torque_current_full_scale_a = 16.5,
     .says = "torque current 16.5 A at 2048",
     .source = "L777, L798"},
};

/// maxSpeed of A4, A6 and A8 counts whole degrees per second (field notes 1).
constexpr std::string_view max_speed_source = "field notes 1: A4/A6/A8 maxSpeed";
constexpr wire::Override whole_degrees[] = {
    {.message = "multi-loop-angle-speed", .field = "max_speed", .scale = 1.0, .source = max_speed_source},
    {.message = "single-loop-angle-speed", .field = "max_speed", .scale = 1.0, .source = max_speed_source},
    {.message = "increment-angle-speed", .field = "max_speed", .scale = 1.0, .source = max_speed_source},
};

constexpr std::uint32_t lk_2_36_reply_base = 0x180;
constexpr std::uint32_t myactuator_reply_base = 0x240;

constexpr Profile lines[] = {
    {.line = {.name = "rmd-2.35", .says = "the manual", .source = "rmd.txt", .messages = manual_messages}},
    {.line = {.name = "lk-2.35",
              .says = "LK-Tech's own V2.35: MF, MG and MS motors",
              .source = "field notes 1, column LK V2.35",
              .messages = lk_2_35_messages,
              .options = {.bits = clear_error_reply_9b},
              .overrides = whole_degrees},
     .dialect = Dialect::lk,
     .voltage_lsb_v = 0.01,
     .phase_current_lsb_a = 0.0,
     .max_speed_lsb_dps = 1.0,
     .clear_error_reply = ClearErrorReply::own_9b,
     .off_requires_run = true},
    {.line = {.name = "lk-2.36",
              .says = "LK-Tech's V2.36: answers on 0x180 + id, speed commands carry a current limit",
              .source = "field notes 1, column LK V2.36",
              .messages = lk_2_36_messages,
              .options = {.bits = clear_error_reply_9b, .can_reply_base = lk_2_36_reply_base},
              .overrides = whole_degrees},
     .dialect = Dialect::lk_2_36,
     .reply_identifier_base = lk_2_36_reply_base,
     .voltage_lsb_v = 0.01,
     .phase_current_lsb_a = 0.0,
     .error_bits = ErrorBits::eight,
     .max_speed_lsb_dps = 1.0,
     .clear_error_reply = ClearErrorReply::own_9b,
     .off_requires_run = true},
    {.line = {.name = "gyems-1.62",
              .says = "GYEMS V1.62: torque commands of 2000 are 32 A",
              .source = "field notes 1, column GYEMS V1.62",
              .messages = gyems_1_62_messages,
              .overrides = whole_degrees},
     .dialect = Dialect::gyems,
     .max_speed_lsb_dps = 1.0},
    {.line = {.name = "myactuator-3",
              .says = "MyActuator RMD-X V3.6 to V4.2: answers on 0x240 + id, currents in 0.01 A",
              .source = "field notes 1, column RMD-X V3.6/V4.2",
              .messages = myactuator_3_messages,
              .options = {.can_reply_base = myactuator_reply_base}},
     .dialect = Dialect::myactuator,
     .reply_identifier_base = myactuator_reply_base,
     .phase_current_lsb_a = 0.01,
     .error_bits = ErrorBits::sixteen,
     .iq_in_centiamperes = true,
     .max_speed_lsb_dps = 1.0},
};

double full_scale_a(const Spec& spec)
{
    return spec.profile.torque_current_full_scale_a.value_or(spec.model->torque_current_full_scale_a);
}

void add(Spec& spec, wire::Override override)
{
    spec.overrides[spec.override_count++] = override;
}

void add_currents(Spec& spec)
{
    if (spec.profile.iq_in_centiamperes)
        return;
    if (spec.model->iq == Iq::power)
        add(spec, {.field = "iq", .range = {-1000, 1000}, .source = spec.model->source});
    else if (const auto iq_a = spec.iq_a())
        add(spec, {.field = "iq", .scale = *iq_a, .source = spec.model->source});
    if (const double phase_a = spec.phase_current_a(); phase_a != spec.profile.phase_current_lsb_a)
        for (const auto* field : {"phase_a_current", "phase_b_current", "phase_c_current"})
            add(spec, {.field = field, .scale = phase_a, .source = spec.model->source});
}

void add_encoder(Spec& spec)
{
    const wire::Range counts{0, (1 << spec.profile.sent_encoder_bits()) - 1};
    for (const auto* field : {"encoder", "encoder_raw", "encoder_offset"})
        add(spec, {.field = field, .range = counts, .source = "4.6; field notes 2.7"});
}

void add_max_speed(Spec& spec)
{
    for (const wire::Override& one : whole_degrees)
        add(spec, {.message = one.message,
                   .field = one.field,
                   .scale = spec.profile.sent_max_speed_lsb_dps(),
                   .source = "R01"});
}

} // namespace

std::span<const Model> models()
{
    return products;
}

const Model* find_model(std::string_view name)
{
    return find_by_name(models(), {}, name);
}

wire::Options Profile::options() const
{
    wire::Options out;
    if (clear_error_reply == ClearErrorReply::own_9b)
        out.bits |= clear_error_reply_9b;
    if (reply_identifier_base != identifier_base)
        out.can_reply_base = reply_identifier_base;
    return out;
}

std::span<const Profile> profiles()
{
    return lines;
}

std::optional<double> Spec::iq_a() const
{
    if (profile.iq_in_centiamperes)
        return 0.01;
    const double full_scale = full_scale_a(*this);
    if (model->iq == Iq::power || full_scale == 0.0)
        return {};
    return full_scale / full_scale_raw;
}

double Spec::phase_current_a() const
{
    return profile.phase_current_lsb_a != 0.0 ? profile.phase_current_lsb_a : full_scale_a(*this) / full_scale_raw;
}

Spec make_spec(const Model& model, const Profile& profile, int id, const DeviceOptions& device)
{
    Spec spec{.model = &model, .profile = profile, .id = id, .device = device};
    spec.profile.line.options = spec.profile.options();
    add_currents(spec);
    add_encoder(spec);
    add_max_speed(spec);
    return spec;
}

} // namespace sinew::rmd
