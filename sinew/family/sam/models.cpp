#include "sinew/family/sam/models.hpp"

#include "sinew/family/lookup.hpp"
#include "sinew/family/sam/messages.hpp"

namespace sinew::sam {
namespace {

// L392, L462, L758: 254 positions have 253 steps (S29).
constexpr PositionScale quick_scale{
    .control = {1, 254}, .sensor = {0, 254}, .centre = 127, .deg_per_unit = 1.08, .span_deg = 273.24};

// L583, L750, L758; "0.0083" of L750 is a misprint (S53), the centre is printed twice as 2047 (S54).
constexpr PositionScale potentiometer_scale{
    .control = {32, 4064}, .sensor = {0, 4095}, .centre = 2047, .deg_per_unit = 0.083, .span_deg = 334.66};

constexpr double potentiometer_a_per_ad8 = 0.01289;  // L394-395, L450-451
constexpr double potentiometer_a_per_ad12 = 0.00081; // L563-564, L605-606
constexpr double encoder_a_per_ad8 = 0.016;          // L396, L452
constexpr double encoder_a_per_ad12 = 0.001;         // L565, L607

constexpr double sam_5_v_per_ad = 0.00483; // L678
constexpr double other_v_per_ad = 0.00886; // L679-680; "SAM-1xx" is the encoder class (S43)
constexpr double v_offset = 0.65;          // L678-680

constexpr Duration potentiometer_window = std::chrono::milliseconds{10}; // L527
constexpr Duration encoder_window = std::chrono::milliseconds{8};        // L527-534 (S58)
constexpr double potentiometer_deg_s = 8.3;                              // L535-536
constexpr double potentiometer_deg_s2 = 8300.0;                          // L556-557

constexpr double potentiometer_boundary_deg = 1.32; // L627-631
constexpr double encoder_boundary_deg = 1.41;       // L617-621

constexpr Ratings ratings(double kgf_cm, double volt, double ampere, double rpm, double volt_min, double volt_max)
{
    return {units::nm_from_kgf_cm(kgf_cm), volt, ampere, units::rad_s_from_rpm(rpm), volt_min, volt_max};
}

constexpr std::string_view ratings_source = "L167-175, L394-396, L450-452, L527-583, L605-631, L678-680, L736-765";

constexpr Model potentiometer(std::string_view name, std::uint8_t number, double v_per_ad, Ratings rated)
{
    return {.name = name,
            .number = number,
            .encoder = false,
            .quick = quick_scale,
            .standard = potentiometer_scale,
            .precise = std::nullopt,
            .current_a_per_ad8 = potentiometer_a_per_ad8,
            .current_a_per_ad12 = potentiometer_a_per_ad12,
            .voltage_v_per_ad = v_per_ad,
            .voltage_offset_v = v_offset,
            .speed_deg_s_per_unit = potentiometer_deg_s,
            .speed_window = potentiometer_window,
            .accel_deg_s2_per_unit = potentiometer_deg_s2,
            .boundary_deg_per_unit = potentiometer_boundary_deg,
            .ratings = rated,
            .source = ratings_source};
}

constexpr Model encoder(std::string_view name, std::uint8_t number, PositionScale standard, PositionScale precise,
                        double deg_s, double deg_s2, Ratings rated)
{
    return {.name = name,
            .number = number,
            .encoder = true,
            .quick = quick_scale,
            .standard = standard,
            .precise = precise,
            .current_a_per_ad8 = encoder_a_per_ad8,
            .current_a_per_ad12 = encoder_a_per_ad12,
            .voltage_v_per_ad = other_v_per_ad,
            .voltage_offset_v = v_offset,
            .speed_deg_s_per_unit = deg_s,
            .speed_window = encoder_window,
            .accel_deg_s2_per_unit = deg_s2,
            .boundary_deg_per_unit = encoder_boundary_deg,
            .ratings = rated,
            .source = ratings_source};
}

// Model numbers: L705-710, L2748-2752. Ratings: L168-173. Standard: L571-579, L736-748, L758-765; the sensor is 15 bit
// wide (L88-90). Precise: L759-765, L773-799 (S23, S56, S57). Speed: L529-534. Acceleration: L542-555 (S59).
constexpr std::array<Model, 6> constants{
    potentiometer("SAM-5", 0x05, sam_5_v_per_ad, ratings(5, 11, 1.5, 130, 6, 15)),
    potentiometer("SAM-20", 0x20, other_v_per_ad, ratings(20, 19, 2, 140, 9, 24)),
    potentiometer("SAM-28", 0x28, other_v_per_ad, ratings(28, 19, 2, 90, 9, 24)),
    encoder("SAM-160EO200", 0x16, {{82, 28927}, {0, 32639}, 14504, 0.01241, 357.99},
            {{566, 202494}, {0, 203059}, 101529, 0.001773, 358.0}, 0.2216, 221.6, ratings(160, 24, 5, 63, 14, 24)),
    encoder("SAM-180EO200", 0x18, {{89, 31530}, {0, 32639}, 15809, 0.01138, 357.99},
            {{704, 252248}, {0, 252951}, 126475, 0.001423, 358.0}, 0.1778, 177.8, ratings(180, 24, 5, 50, 14, 24)),
    encoder("SAM-210EO200", 0x21, {{86, 30224}, {0, 32639}, 15154, 0.01187, 357.99},
            {{843, 302251}, {0, 303093}, 151546, 0.001187, 358.0}, 0.1483, 148.3, ratings(210, 24, 5, 42, 14, 24)),
};

/// A scale whose zero is the centre.
constexpr wire::Override centred(std::string_view message, std::string_view field, Range range, double deg, int centre)
{
    return {.message = message, .field = field, .range = range, .scale = deg, .offset = -centre * deg};
}

constexpr wire::Override scaled(std::string_view message, std::string_view field, double scale, double offset = 0.0)
{
    return {.message = message, .field = field, .scale = scale, .offset = offset};
}

/// What the rows leave to the model, worked out from the constants above.
constexpr auto overrides(const Model& m)
{
    const PositionScale precise = m.precise.value_or(PositionScale{});
    const auto quick = [&](std::string_view message, std::string_view field, Range range = {}) {
        return centred(message, field, range, m.quick.deg_per_unit, m.quick.centre);
    };
    const auto boundary = [&](std::string_view message, std::string_view field) {
        return centred(message, field, {}, m.boundary_deg_per_unit, boundary_centre);
    };
    const auto standard = [&](std::string_view message, std::string_view field, Range range) {
        return centred(message, field, range, m.standard.deg_per_unit, m.standard.centre);
    };
    const auto fine = [&](std::string_view message, std::string_view field, Range range) {
        return m.precise ? centred(message, field, range, precise.deg_per_unit, precise.centre)
                         : wire::Override{.message = message, .field = field};
    };
    return std::array{quick("quick-position-control", "target_position", m.quick.control),
                      quick("quick-position-control", "position"),
                      quick("quick-read-status", "position"),
                      quick("quick-wheel-mode", "position"),
                      quick("quick-brake-mode", "position"),
                      quick("quick-set-boundary", "upper_boundary"),
                      quick("quick-set-boundary", "lower_boundary"),
                      quick("quick-read-boundary", "upper_boundary"),
                      quick("quick-read-boundary", "lower_boundary"),
                      standard("position-control", "target_position", m.standard.control),
                      standard("position-control", "position", m.standard.sensor),
                      standard("read-current-position", "position", m.standard.sensor),
                      fine("precise-position-control", "target_position", precise.control),
                      fine("precise-position-control", "position", precise.sensor),
                      fine("read-precise-position", "position", precise.sensor),
                      boundary("set-boundary", "upper_boundary"),
                      boundary("set-boundary", "lower_boundary"),
                      boundary("read-boundary", "upper_boundary"),
                      boundary("read-boundary", "lower_boundary"),
                      scaled("quick-position-control", "load", m.current_a_per_ad8),
                      scaled("quick-read-status", "load", m.current_a_per_ad8),
                      scaled("quick-set-overload", "overload", m.current_a_per_ad8),
                      scaled("quick-read-overload", "overload", m.current_a_per_ad8),
                      scaled("set-overload", "overload", m.current_a_per_ad12),
                      scaled("read-overload", "overload", m.current_a_per_ad12),
                      scaled("read-current-load", "current_load", m.current_a_per_ad12),
                      scaled("read-current-speed", "current_speed", m.speed_deg_s_per_unit),
                      scaled("read-current-accel", "current_accel", m.accel_deg_s2_per_unit),
                      scaled("read-input-voltage", "input_voltage", m.voltage_v_per_ad, m.voltage_offset_v)};
}

template <std::size_t I>
constexpr auto overrides_of = overrides(constants[I]);

template <std::size_t... I>
constexpr std::array<Model, sizeof...(I)> with_overrides(std::index_sequence<I...>)
{
    std::array<Model, sizeof...(I)> all{constants};
    ((all[I].overrides = overrides_of<I>), ...);
    return all;
}

constexpr auto products = with_overrides(std::make_index_sequence<constants.size()>{});

/// Other spellings: L167 has a zero in "E0200", people leave the ending out (S43).
constexpr Alias aliases[] = {{"SAM-160", "SAM-160EO200"},      {"SAM-180", "SAM-180EO200"},
                             {"SAM-210", "SAM-210EO200"},      {"SAM-160E0200", "SAM-160EO200"},
                             {"SAM-180E0200", "SAM-180EO200"}, {"SAM-210E0200", "SAM-210EO200"}};

} // namespace

std::span<const Model> models()
{
    return products;
}

const Model* find_model(std::string_view name)
{
    return find_by_name(models(), aliases, name);
}

const Model* find_model(std::uint8_t number)
{
    for (const Model& model : products)
        if (model.number == number)
            return &model;
    return nullptr;
}

bool Profile::answers(const wire::MessageInfo& message) const
{
    const bool is_ping = message.info.opcode == row<Ping>.info.opcode;
    const bool is_read = !message.info.answered_as_command && (ping_is_read || !is_ping);
    return response_level == 1 || (response_level == 0 && is_read);
}

wire::Options Profile::options() const
{
    wire::Options out;
    if (quick_boundary_order == BoundaryOrder::lower_then_upper)
        out.bits |= quick_boundary_lower_first;
    if (quick_port_bits == PortBits::do_low)
        out.bits |= quick_port_outputs_low;
    return out;
}

std::span<const Profile> profiles()
{
    static constexpr Profile lines[] = {{.line = {.name = "sam-1.0",
                                                  .says = "the manual, with the readings of its contradictions",
                                                  .source = "SAM series User Manual Ver 1.0",
                                                  .messages = manual_messages}}};
    return lines;
}

} // namespace sinew::sam
