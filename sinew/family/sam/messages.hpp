#pragma once
#include "sinew/wire/message.hpp"

#include <array>
#include <cstdint>

/// SAM: 57 messages. Source: SAM series User Manual Ver 1.0; opcodes and layouts with the resolutions named in each row
/// (README.md of this folder). Requests count the header as byte 0, replies start at byte 0.
namespace sinew::sam {

using namespace wire;

// ---- options of a firmware line ----

/// The quick boundary commands carry the lower boundary first, as the code listing does (S32). Off: upper first.
inline constexpr std::uint32_t quick_boundary_lower_first = 1U << 0;
/// The quick port command carries the outputs in bits 1:0 and the LEDs above, as its footnote says (S34). Off: LEDs
/// low.
inline constexpr std::uint32_t quick_port_outputs_low = 1U << 1;

inline constexpr When upper_first{quick_boundary_lower_first, 0};
inline constexpr When lower_first{quick_boundary_lower_first, quick_boundary_lower_first};
inline constexpr When leds_low{quick_port_outputs_low, 0};
inline constexpr When outputs_low{quick_port_outputs_low, quick_port_outputs_low};

// ---- words for raw values ----

enum class QuickSpin : std::uint8_t { counter_clockwise = 3, clockwise = 4 };
inline constexpr Label quick_spins[] = {{3, "CCW"}, {4, "CW"}};

enum class Mode : std::uint8_t { position, passive, brake, wheel };
inline constexpr Label modes[] = {{0, "general"}, {1, "passive"}, {2, "brake"}, {3, "wheel"}};

/// L424-436; the list of L1624 belongs to an older product (S05).
inline constexpr Label baud_codes[] = {{0, "2000000"}, {1, "1500000"}, {2, "1000000"}, {3, "500000"}, {4, "230400"},
                                       {5, "115200"},  {6, "57600"},   {7, "38400"},   {8, "9600"},   {9, "4800"}};

/// L705-710 and L2748-2752; SAM-140 stands only in the latter (S52).
inline constexpr Label model_numbers[] = {{0x05, "SAM-5"},        {0x14, "SAM-140"}, {0x16, "SAM-160EO200"},
                                          {0x18, "SAM-180EO200"}, {0x20, "SAM-20"},  {0x21, "SAM-210EO200"},
                                          {0x28, "SAM-28"}};

inline constexpr Label temperature_states[] = {{0, "ok"}, {1, "overheated"}};

inline constexpr std::string_view encoder_models = "encoder models (SAM-160EO200, SAM-180EO200, SAM-210EO200)";

// ---- framing (L755, L829; S22, S67) ----

inline constexpr Field header = constant("header", 0, 0xFF);
inline constexpr Field sum{.name = "checksum", .from_end = true, .kind = Kind::checksum};

consteval Field quick_id(std::int64_t highest)
{
    return {.name = "id", .byte = 1, .msb = 4, .lsb = 0, .kind = Kind::address, .range = {0, highest}};
}

consteval Field opcode_byte()
{
    return {.name = "opcode", .byte = 2, .kind = Kind::opcode};
}

inline constexpr Field quick_fields[] = {header, quick_id(30), sum};
inline constexpr Field quick_all_fields[] = {header, quick_id(31), sum};
inline constexpr Field quick_set_fields[] = {header, constant_bits("mode", 1, 7, 5, 7), quick_id(30), opcode_byte(),
                                             sum};
inline constexpr Field standard_fields[] = {header,
                                            constant("data1", 1, 0xE0),
                                            opcode_byte(),
                                            {.name = "id", .byte = 3, .kind = Kind::address, .range = {0, 254}},
                                            sum};

/// Four bytes; bits 7:5 of the second belong to the message.
inline constexpr Layout quick{.name = "quick", .checksum = Checksum::xor7, .fields = quick_fields, .ids = {0, 30}};
/// As `quick`; id 31 is all devices (S25).
inline constexpr Layout quick_all{
    .name = "quick", .checksum = Checksum::xor7, .fields = quick_all_fields, .ids = {0, 31}};
inline constexpr Layout quick_set{
    .name = "quick set", .checksum = Checksum::xor7, .fields = quick_set_fields, .ids = {0, 30}};
inline constexpr Layout standard{
    .name = "standard", .checksum = Checksum::xor7, .fields = standard_fields, .ids = {0, 254}};
/// Replies are bare bytes: no header, no id, no checksum (S68).
inline constexpr Layout bare{.name = "bare reply"};

template <class M>
consteval auto quick_boundary(std::uint8_t M::* member, std::string_view name, int byte, Range range, When when,
                              Range recommended = {})
{
    return u8(member, {.name = name,
                       .byte = static_cast<std::uint8_t>(byte),
                       .range = range,
                       .recommended = recommended,
                       .unit = "deg",
                       .scale = 1.08,
                       .when = when});
}

template <class M>
consteval auto port_bit(bool M::* member, std::string_view name, int byte, int bit, When when)
{
    return bits(member, bit, bit,
                {.name = name, .byte = static_cast<std::uint8_t>(byte), .range = {0, 1}, .when = when});
}

struct QuickPositionControl {
    std::uint8_t torque_level{};
    std::uint8_t target_position{};
};
struct QuickState {
    std::uint8_t load{};
    std::uint8_t position{};
};
consteval auto row_of(const QuickPositionControl*)
{
    return message<QuickPositionControl, QuickState>(
        {.name = "quick-position-control",
         .access = Access::command,
         .moves = true,
         .answered_as_command = true,
         .manual = "A-1-1 (1); 2-3-1 (1)",
         .errata = "S28 S29 S22 S73 S84",
         .says = "Go to a position in quick coordinates at one of five torque levels."},
        side<QuickPositionControl>(
            quick, 4,
            bits(&QuickPositionControl::torque_level, 7, 5,
                 {.name = "torque_level", .byte = 1, .range = {0, 4}, .says = "0 is the strongest, 4 the weakest"}),
            u8(&QuickPositionControl::target_position, {.name = "target_position",
                                                        .byte = 2,
                                                        .range = {0, 254},
                                                        .recommended = {1, 254},
                                                        .unit = "deg",
                                                        .scale = 1.08})),
        side<QuickState>(
            bare, 2,
            u8(&QuickState::load, {.name = "load", .byte = 0, .range = {0, 254}, .unit = "A", .scale = by_model}),
            u8(&QuickState::position,
               {.name = "position", .byte = 1, .range = {0, 254}, .unit = "deg", .scale = 1.08})));
}

struct QuickReadStatus {
};
consteval auto row_of(const QuickReadStatus*)
{
    return message<QuickReadStatus, QuickState>(
        {.name = "quick-read-status",
         .manual = "A-1-1 (2); 2-3-1 (2) 'Load Position'; 2-2-1-1 (2) 'Load Status'",
         .says = "Read the average motor current and the position."},
        side<QuickReadStatus>(quick, 4, constant_bits("mode", 1, 7, 5, 5), reserved("dont_care", 2)),
        side<QuickState>(
            bare, 2,
            u8(&QuickState::load, {.name = "load", .byte = 0, .range = {0, 254}, .unit = "A", .scale = by_model}),
            u8(&QuickState::position,
               {.name = "position", .byte = 1, .range = {0, 254}, .unit = "deg", .scale = 1.08})));
}

struct QuickPassiveMode {
};
struct Identity {
    std::uint8_t id{};
};
consteval auto row_of(const QuickPassiveMode*)
{
    return message<QuickPassiveMode, Identity>(
        {.name = "quick-passive-mode",
         .access = Access::command,
         .moves = true,
         .answered_as_command = true,
         .manual = "A-1-1 (3); 2-3-1 (3)",
         .errata = "S26",
         .says = "Release the torque so that the shaft can be turned by hand."},
        side<QuickPassiveMode>(quick, 4, constant_bits("mode", 1, 7, 5, 6), constant_bits("submode", 2, 7, 4, 1),
                               reserved("dont_care", 2, 3, 0)),
        side<Identity>(bare, 2, u8(&Identity::id, {.name = "id", .byte = 0, .range = {0, 30}}),
                       repeat("id_repeat", 1, 0)));
}

struct QuickWheelMode {
    QuickSpin direction{};
    std::uint8_t speed{};
};
struct QuickTurns {
    std::uint8_t rotation_no{};
    std::uint8_t position{};
};
consteval auto row_of(const QuickWheelMode*)
{
    return message<QuickWheelMode, QuickTurns>(
        {.name = "quick-wheel-mode",
         .access = Access::command,
         .moves = true,
         .answered_as_command = true,
         .manual = "A-1-1 (4); 2-3-1 (4) '360 deg Rotation Mode'",
         .errata = "S27 S42",
         .says = "Turn without end at a constant PWM duty."},
        side<QuickWheelMode>(
            quick, 4, constant_bits("mode", 1, 7, 5, 6),
            bits(&QuickWheelMode::direction, 7, 4,
                 {.name = "direction", .byte = 2, .range = {3, 4}, .labels = quick_spins}),
            bits(&QuickWheelMode::speed, 3, 0,
                 {.name = "speed", .byte = 2, .range = {0, 15}, .says = "0 stops, 1 is 15 % and 15 is 50 % PWM duty"})),
        side<QuickTurns>(bare, 2,
                         u8(&QuickTurns::rotation_no, {.name = "rotation_no",
                                                       .byte = 0,
                                                       .range = {0, 255},
                                                       .says = "meaning not documented; read as a turn counter"}),
                         u8(&QuickTurns::position,
                            {.name = "position", .byte = 1, .range = {0, 254}, .unit = "deg", .scale = 1.08})));
}

struct QuickBrakeMode {
};
struct QuickBrakeState {
    std::uint8_t id{};
    std::uint8_t position{};
};
consteval auto row_of(const QuickBrakeMode*)
{
    return message<QuickBrakeMode, QuickBrakeState>(
        {.name = "quick-brake-mode",
         .access = Access::command,
         .moves = true,
         .answered_as_command = true,
         .broadcast = true,
         .manual = "A-1-1 (5); 2-3-1 (5); 2-1-6",
         .errata = "S25",
         .says = "Short the motor terminals; id 31 brakes all devices of the line."},
        side<QuickBrakeMode>(quick_all, 4, constant_bits("mode", 1, 7, 5, 6), constant_bits("submode", 2, 7, 4, 2),
                             reserved("arbitrary", 2, 3, 0)),
        side<QuickBrakeState>(bare, 2, u8(&QuickBrakeState::id, {.name = "id", .byte = 0, .range = {0, 30}}),
                              u8(&QuickBrakeState::position,
                                 {.name = "position", .byte = 1, .range = {0, 254}, .unit = "deg", .scale = 1.08})));
}

struct QuickSetBaudRate {
    std::uint8_t baud_code{};
};
struct NewBaudRate {
    std::uint8_t new_baud_code{};
};
consteval auto row_of(const QuickSetBaudRate*)
{
    return message<QuickSetBaudRate, NewBaudRate>(
        {.name = "quick-set-baud-rate",
         .opcode = 0x08,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-2 (1); 2-3-2 (1)",
         .errata = "S01 S70",
         .says = "Store another bit rate."},
        side<QuickSetBaudRate>(
            quick_set, 6,
            u8(&QuickSetBaudRate::baud_code, {.name = "baud_code", .byte = 3, .range = {0, 9}, .labels = baud_codes}),
            repeat("baud_code_repeat", 4, 3)),
        side<NewBaudRate>(bare, 2,
                          u8(&NewBaudRate::new_baud_code,
                             {.name = "new_baud_code", .byte = 0, .range = {0, 9}, .labels = baud_codes}),
                          repeat("new_baud_code_repeat", 1, 0)));
}

struct QuickSetRuntimePdGain {
    std::uint8_t p_gain{};
    std::uint8_t d_gain{};
};
struct PdGain {
    std::uint8_t p_gain{};
    std::uint8_t d_gain{};
};
consteval auto row_of(const QuickSetRuntimePdGain*)
{
    return message<QuickSetRuntimePdGain, PdGain>(
        {.name = "quick-set-runtime-pd-gain",
         .opcode = 0x0B,
         .access = Access::command,
         .answered_as_command = true,
         .manual = "A-1-2 (2); 2-3-2 (2)",
         .errata = "S02 S38",
         .says = "Set the P and D gains until power-off."},
        side<QuickSetRuntimePdGain>(
            quick_set, 6, u8(&QuickSetRuntimePdGain::p_gain, {.name = "p_gain", .byte = 3, .range = {1, 254}}),
            u8(&QuickSetRuntimePdGain::d_gain, {.name = "d_gain", .byte = 4, .range = {0, 254}})),
        side<PdGain>(bare, 2, u8(&PdGain::p_gain, {.name = "p_gain", .byte = 0, .range = {1, 254}}),
                     u8(&PdGain::d_gain, {.name = "d_gain", .byte = 1, .range = {0, 254}})));
}

struct QuickSetId {
    std::uint8_t new_id{};
};
struct NewId {
    std::uint8_t new_id{};
};
consteval auto row_of(const QuickSetId*)
{
    return message<QuickSetId, NewId>(
        {.name = "quick-set-id",
         .opcode = 0x0C,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-2 (3) '5 Bit ID'; 2-3-2 (3)",
         .errata = "S30 S70",
         .says = "Store another id."},
        side<QuickSetId>(
            quick_set, 6,
            u8(&QuickSetId::new_id, {.name = "new_id", .byte = 3, .range = {0, 254}, .recommended = {0, 30}}),
            repeat("new_id_repeat", 4, 3)),
        side<NewId>(bare, 2, u8(&NewId::new_id, {.name = "new_id", .byte = 0, .range = {0, 254}}),
                    repeat("new_id_repeat", 1, 0)));
}

struct QuickSetOverload {
    std::uint8_t overload{};
};
struct QuickOverload {
    std::uint8_t overload{};
};
consteval auto row_of(const QuickSetOverload*)
{
    return message<QuickSetOverload, QuickOverload>(
        {.name = "quick-set-overload",
         .opcode = 0x0F,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-2 (4); 2-3-2 (4)",
         .errata = "S31 S44 S60",
         .says = "Store the current above which the device goes passive."},
        side<QuickSetOverload>(quick_set, 6,
                               u8(&QuickSetOverload::overload,
                                  {.name = "overload", .byte = 3, .range = {0, 254}, .unit = "A", .scale = by_model}),
                               repeat("overload_repeat", 4, 3)),
        side<QuickOverload>(bare, 2,
                            u8(&QuickOverload::overload,
                               {.name = "overload", .byte = 0, .range = {0, 254}, .unit = "A", .scale = by_model}),
                            repeat("overload_repeat", 1, 0)));
}

struct QuickReadOverload {
};
consteval auto row_of(const QuickReadOverload*)
{
    return message<QuickReadOverload, QuickOverload>(
        {.name = "quick-read-overload",
         .opcode = 0x10,
         .manual = "A-1-2 (5); 2-3-2 (5)",
         .errata = "S60",
         .says = "Read the overload current."},
        side<QuickReadOverload>(quick_set, 6, reserved("dont_care_1", 3), reserved("dont_care_2", 4)),
        side<QuickOverload>(bare, 2,
                            u8(&QuickOverload::overload,
                               {.name = "overload", .byte = 0, .range = {0, 254}, .unit = "A", .scale = by_model}),
                            repeat("overload_repeat", 1, 0)));
}

struct QuickSetBoundary {
    std::uint8_t upper_boundary{};
    std::uint8_t lower_boundary{};
};
struct Boundary {
    std::uint8_t upper_boundary{};
    std::uint8_t lower_boundary{};
};
/// The answer to both quick boundary commands; a careful host sorts the two (S32).
consteval auto quick_boundary_reply(Range recommended = {})
{
    return side<Boundary>(
        bare, 2, quick_boundary(&Boundary::upper_boundary, "upper_boundary", 0, {0, 254}, upper_first, recommended),
        quick_boundary(&Boundary::lower_boundary, "lower_boundary", 1, {0, 254}, upper_first, recommended),
        quick_boundary(&Boundary::upper_boundary, "upper_boundary", 1, {0, 254}, lower_first, recommended),
        quick_boundary(&Boundary::lower_boundary, "lower_boundary", 0, {0, 254}, lower_first, recommended));
}
consteval auto row_of(const QuickSetBoundary*)
{
    return message<QuickSetBoundary, Boundary>(
        {.name = "quick-set-boundary",
         .opcode = 0x11,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-2 (6); 2-3-2 (6)",
         .errata = "S03 S32 S33 S61",
         .says = "Store the range that positions are limited to, in quick coordinates."},
        side<QuickSetBoundary>(
            quick_set, 6,
            quick_boundary(&QuickSetBoundary::upper_boundary, "upper_boundary", 3, {1, 254}, upper_first, {2, 254}),
            quick_boundary(&QuickSetBoundary::lower_boundary, "lower_boundary", 4, {0, 253}, upper_first, {1, 253}),
            quick_boundary(&QuickSetBoundary::upper_boundary, "upper_boundary", 4, {1, 254}, lower_first, {2, 254}),
            quick_boundary(&QuickSetBoundary::lower_boundary, "lower_boundary", 3, {0, 253}, lower_first, {1, 253})),
        quick_boundary_reply());
}

struct QuickReadBoundary {
};
consteval auto row_of(const QuickReadBoundary*)
{
    return message<QuickReadBoundary, Boundary>(
        {.name = "quick-read-boundary",
         .opcode = 0x12,
         .manual = "A-1-2 (7); 2-3-2 (7) 'Load Movement Range'",
         .errata = "S32 S33 S61",
         .says = "Read the boundaries in quick coordinates."},
        side<QuickReadBoundary>(quick_set, 6, reserved("dont_care_1", 3), reserved("dont_care_2", 4)),
        quick_boundary_reply({1, 254}));
}

struct QuickWriteExternalPort {
    bool led_red{};
    bool led_blue{};
    bool do1{};
    bool do2{};
};
struct ExternalPort {
    bool led_red{};
    bool led_blue{};
    bool do1{};
    bool do2{};
};
consteval auto row_of(const QuickWriteExternalPort*)
{
    return message<QuickWriteExternalPort, ExternalPort>(
        {.name = "quick-write-external-port",
         .opcode = 0x64,
         .access = Access::command,
         .answered_as_command = true,
         .restriction = encoder_models,
         .manual = "A-1-3 (1); 2-3-3 (1)",
         .errata = "S34 S43 S49",
         .says = "Switch the LEDs and the two digital outputs."},
        side<QuickWriteExternalPort>(quick_set, 6,
                                     port_bit(&QuickWriteExternalPort::led_red, "led_red", 3, 0, leds_low),
                                     port_bit(&QuickWriteExternalPort::led_blue, "led_blue", 3, 1, leds_low),
                                     port_bit(&QuickWriteExternalPort::do1, "do1", 3, 2, leds_low),
                                     port_bit(&QuickWriteExternalPort::do2, "do2", 3, 3, leds_low),
                                     port_bit(&QuickWriteExternalPort::do1, "do1", 3, 0, outputs_low),
                                     port_bit(&QuickWriteExternalPort::do2, "do2", 3, 1, outputs_low),
                                     port_bit(&QuickWriteExternalPort::led_red, "led_red", 3, 2, outputs_low),
                                     port_bit(&QuickWriteExternalPort::led_blue, "led_blue", 3, 3, outputs_low),
                                     reserved("reserved_7_4", 3, 7, 4), repeat("port_repeat", 4, 3)),
        side<ExternalPort>(bare, 2, port_bit(&ExternalPort::led_red, "led_red", 0, 0, leds_low),
                           port_bit(&ExternalPort::led_blue, "led_blue", 0, 1, leds_low),
                           port_bit(&ExternalPort::do1, "do1", 0, 2, leds_low),
                           port_bit(&ExternalPort::do2, "do2", 0, 3, leds_low),
                           port_bit(&ExternalPort::do1, "do1", 0, 0, outputs_low),
                           port_bit(&ExternalPort::do2, "do2", 0, 1, outputs_low),
                           port_bit(&ExternalPort::led_red, "led_red", 0, 2, outputs_low),
                           port_bit(&ExternalPort::led_blue, "led_blue", 0, 3, outputs_low),
                           reserved("reserved_7_4", 0, 7, 4), repeat("port_repeat", 1, 0)));
}

struct QuickReadExternalAd {
};
struct ExternalAd {
    std::uint16_t external_ad{};
};
consteval auto row_of(const QuickReadExternalAd*)
{
    return message<QuickReadExternalAd, ExternalAd>(
        {.name = "quick-read-external-ad",
         .opcode = 0x65,
         .restriction = encoder_models,
         .manual = "A-1-3 (2); 2-3-3 (2)",
         .errata = "S04 S72",
         .says = "Read the analogue input of the external port."},
        side<QuickReadExternalAd>(quick_set, 6, reserved("dont_care_1", 3), reserved("dont_care_2", 4)),
        side<ExternalAd>(
            bare, 2,
            septets(&ExternalAd::external_ad, 5, 2,
                    {.name = "external_ad", .byte = 0, .range = {0, 4095}, .unit = "V", .scale = 0.001343})));
}

struct QuickWriteMotionData {
    std::uint8_t motion_count{};
    std::array<wire::Pair, 8> instructions{};
};
struct MotionCount {
    std::uint8_t motion_count{};
};
consteval auto row_of(const QuickWriteMotionData*)
{
    return message<QuickWriteMotionData, MotionCount>(
        {.name = "quick-write-motion-data",
         .opcode = 0x96,
         .access = Access::flash,
         .moves = true,
         .answered_as_command = true,
         .manual = "A-1-3 (3); 2-3-3 (3)",
         .errata = "S64 S65 S81 S22",
         .says = "Store a self-running program of up to eight instructions; none switches it off."},
        side<QuickWriteMotionData>(
            quick_set, 5, u8(&QuickWriteMotionData::motion_count, {.name = "motion_count", .byte = 3, .range = {0, 8}}),
            pairs(&QuickWriteMotionData::instructions, &QuickWriteMotionData::motion_count,
                  {.name = "instructions",
                   .byte = 4,
                   .range = {0, 254},
                   .says = "command and data byte of each instruction"})),
        side<MotionCount>(bare, 2, u8(&MotionCount::motion_count, {.name = "motion_count", .byte = 0, .range = {0, 8}}),
                          repeat("motion_count_repeat", 1, 0)));
}

struct QuickReadMotionData {
};
consteval auto row_of(const QuickReadMotionData*)
{
    return message<QuickReadMotionData, MotionCount>(
        {.name = "quick-read-motion-data",
         .opcode = 0x97,
         .manual = "A-1-3 (4); 2-3-3 (4) 'Load DATA Data'",
         .says = "Read how many instructions the stored program has."},
        side<QuickReadMotionData>(quick_set, 6, reserved("dont_care_1", 3), reserved("dont_care_2", 4)),
        side<MotionCount>(bare, 2, u8(&MotionCount::motion_count, {.name = "motion_count", .byte = 0, .range = {0, 8}}),
                          repeat("motion_count_repeat", 1, 0)));
}

struct SetId {
    std::uint8_t new_id{};
};
consteval auto row_of(const SetId*)
{
    return message<SetId, NewId>(
        {.name = "set-id",
         .opcode = 0xA0,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-4 (1); 2-3-4 (1)",
         .errata = "S70 S80",
         .says = "Store another id."},
        side<SetId>(standard, 7, u8(&SetId::new_id, {.name = "new_id", .byte = 4, .range = {0, 254}}),
                    repeat("new_id_repeat", 5, 4)),
        side<NewId>(bare, 2, u8(&NewId::new_id, {.name = "new_id", .byte = 0, .range = {0, 254}}),
                    repeat("new_id_repeat", 1, 0)));
}

struct SetBaudRate {
    std::uint8_t baud_code{};
};
consteval auto row_of(const SetBaudRate*)
{
    return message<SetBaudRate, NewBaudRate>(
        {.name = "set-baud-rate",
         .opcode = 0xA1,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-4 (2); 2-3-4 (2)",
         .errata = "S05 S70 S80",
         .says = "Store another bit rate."},
        side<SetBaudRate>(
            standard, 7,
            u8(&SetBaudRate::baud_code, {.name = "baud_code", .byte = 4, .range = {0, 9}, .labels = baud_codes}),
            repeat("baud_code_repeat", 5, 4)),
        side<NewBaudRate>(bare, 2,
                          u8(&NewBaudRate::new_baud_code,
                             {.name = "new_baud_code", .byte = 0, .range = {0, 9}, .labels = baud_codes}),
                          repeat("new_baud_code_repeat", 1, 0)));
}

struct SetCtrlSpeed {
    std::uint16_t ctrl_speed{};
};
struct CtrlSpeed {
    std::uint16_t ctrl_speed{};
};
consteval auto row_of(const SetCtrlSpeed*)
{
    return message<SetCtrlSpeed, CtrlSpeed>(
        {.name = "set-ctrl-speed",
         .opcode = 0xA2,
         .access = Access::command,
         .answered_as_command = true,
         .manual = "A-2 only",
         .errata = "S36",
         .says = "Set the control speed, a register that only the code listing names."},
        side<SetCtrlSpeed>(
            standard, 7,
            septets(&SetCtrlSpeed::ctrl_speed, 5, 2,
                    {.name = "ctrl_speed", .byte = 4, .range = {0, 4095}, .says = "unit not documented"})),
        side<CtrlSpeed>(bare, 2,
                        septets(&CtrlSpeed::ctrl_speed, 5, 2,
                                {.name = "ctrl_speed", .byte = 0, .range = {0, 4095}, .says = "unit not documented"})));
}

struct ReadCtrlSpeed {
};
consteval auto row_of(const ReadCtrlSpeed*)
{
    return message<ReadCtrlSpeed, CtrlSpeed>(
        {.name = "read-ctrl-speed",
         .opcode = 0xA3,
         .manual = "A-2 only",
         .errata = "S36",
         .says = "Read the control speed."},
        side<ReadCtrlSpeed>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<CtrlSpeed>(bare, 2,
                        septets(&CtrlSpeed::ctrl_speed, 5, 2,
                                {.name = "ctrl_speed", .byte = 0, .range = {0, 4095}, .says = "unit not documented"})));
}

struct SetCtrlTorque {
    std::uint16_t ctrl_torque{};
};
struct CtrlTorque {
    std::uint16_t ctrl_torque{};
};
consteval auto row_of(const SetCtrlTorque*)
{
    return message<SetCtrlTorque, CtrlTorque>(
        {.name = "set-ctrl-torque",
         .opcode = 0xA4,
         .access = Access::command,
         .answered_as_command = true,
         .manual = "A-2 only",
         .errata = "S36",
         .says = "Set the control torque, a register that only the code listing names."},
        side<SetCtrlTorque>(
            standard, 7,
            septets(&SetCtrlTorque::ctrl_torque, 5, 2,
                    {.name = "ctrl_torque", .byte = 4, .range = {0, 4095}, .says = "unit not documented"})),
        side<CtrlTorque>(
            bare, 2,
            septets(&CtrlTorque::ctrl_torque, 5, 2,
                    {.name = "ctrl_torque", .byte = 0, .range = {0, 4095}, .says = "unit not documented"})));
}

struct ReadCtrlTorque {
};
consteval auto row_of(const ReadCtrlTorque*)
{
    return message<ReadCtrlTorque, CtrlTorque>(
        {.name = "read-ctrl-torque",
         .opcode = 0xA5,
         .manual = "A-2 only",
         .errata = "S36",
         .says = "Read the control torque."},
        side<ReadCtrlTorque>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<CtrlTorque>(
            bare, 2,
            septets(&CtrlTorque::ctrl_torque, 5, 2,
                    {.name = "ctrl_torque", .byte = 0, .range = {0, 4095}, .says = "unit not documented"})));
}

struct SetCtrlAccel {
    std::uint16_t ctrl_accel{};
};
struct CtrlAccel {
    std::uint16_t ctrl_accel{};
};
consteval auto row_of(const SetCtrlAccel*)
{
    return message<SetCtrlAccel, CtrlAccel>(
        {.name = "set-ctrl-accel",
         .opcode = 0xA6,
         .access = Access::command,
         .answered_as_command = true,
         .manual = "A-2 only",
         .errata = "S36",
         .says = "Set the control acceleration, a register that only the code listing names."},
        side<SetCtrlAccel>(
            standard, 7,
            septets(&SetCtrlAccel::ctrl_accel, 5, 2,
                    {.name = "ctrl_accel", .byte = 4, .range = {0, 4095}, .says = "unit not documented"})),
        side<CtrlAccel>(bare, 2,
                        septets(&CtrlAccel::ctrl_accel, 5, 2,
                                {.name = "ctrl_accel", .byte = 0, .range = {0, 4095}, .says = "unit not documented"})));
}

struct ReadCtrlAccel {
};
consteval auto row_of(const ReadCtrlAccel*)
{
    return message<ReadCtrlAccel, CtrlAccel>(
        {.name = "read-ctrl-accel",
         .opcode = 0xA7,
         .manual = "A-2 only",
         .errata = "S36",
         .says = "Read the control acceleration."},
        side<ReadCtrlAccel>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<CtrlAccel>(bare, 2,
                        septets(&CtrlAccel::ctrl_accel, 5, 2,
                                {.name = "ctrl_accel", .byte = 0, .range = {0, 4095}, .says = "unit not documented"})));
}

struct SetCtrlDecel {
    std::uint16_t ctrl_decel{};
};
struct CtrlDecel {
    std::uint16_t ctrl_decel{};
};
consteval auto row_of(const SetCtrlDecel*)
{
    return message<SetCtrlDecel, CtrlDecel>(
        {.name = "set-ctrl-decel",
         .opcode = 0xA8,
         .access = Access::command,
         .answered_as_command = true,
         .manual = "A-2 only",
         .errata = "S36",
         .says = "Set the control deceleration, a register that only the code listing names."},
        side<SetCtrlDecel>(
            standard, 7,
            septets(&SetCtrlDecel::ctrl_decel, 5, 2,
                    {.name = "ctrl_decel", .byte = 4, .range = {0, 4095}, .says = "unit not documented"})),
        side<CtrlDecel>(bare, 2,
                        septets(&CtrlDecel::ctrl_decel, 5, 2,
                                {.name = "ctrl_decel", .byte = 0, .range = {0, 4095}, .says = "unit not documented"})));
}

struct ReadCtrlDecel {
};
consteval auto row_of(const ReadCtrlDecel*)
{
    return message<ReadCtrlDecel, CtrlDecel>(
        {.name = "read-ctrl-decel",
         .opcode = 0xA9,
         .manual = "A-2 only",
         .errata = "S36",
         .says = "Read the control deceleration."},
        side<ReadCtrlDecel>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<CtrlDecel>(bare, 2,
                        septets(&CtrlDecel::ctrl_decel, 5, 2,
                                {.name = "ctrl_decel", .byte = 0, .range = {0, 4095}, .says = "unit not documented"})));
}

struct ReadCurrentSpeed {
};
struct CurrentSpeed {
    std::int16_t current_speed{};
};
consteval auto row_of(const ReadCurrentSpeed*)
{
    return message<ReadCurrentSpeed, CurrentSpeed>(
        {.name = "read-current-speed",
         .opcode = 0xAA,
         .manual = "A-1-4 (3); 2-3-4 (3)",
         .errata = "S40 S58 S57",
         .says = "Read the speed, measured as the change of position over 10 ms (8 ms on encoder models)."},
        side<ReadCurrentSpeed>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<CurrentSpeed>(
            bare, 2,
            signed_septets(
                &CurrentSpeed::current_speed,
                {.name = "current_speed", .byte = 0, .range = {-4095, 4095}, .unit = "deg/s", .scale = by_model})));
}

struct ReadCurrentAccel {
};
struct CurrentAccel {
    std::int16_t current_accel{};
};
consteval auto row_of(const ReadCurrentAccel*)
{
    return message<ReadCurrentAccel, CurrentAccel>(
        {.name = "read-current-accel",
         .opcode = 0xAB,
         .manual = "A-1-4 (4); 2-3-4 (4)",
         .errata = "S15 S40 S59",
         .says = "Read the change of speed over 1 ms."},
        side<ReadCurrentAccel>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<CurrentAccel>(
            bare, 2,
            signed_septets(
                &CurrentAccel::current_accel,
                {.name = "current_accel", .byte = 0, .range = {-1023, 1023}, .unit = "deg/s^2", .scale = by_model})));
}

struct ReadCurrentLoad {
};
struct CurrentLoad {
    std::uint16_t current_load{};
};
consteval auto row_of(const ReadCurrentLoad*)
{
    return message<ReadCurrentLoad, CurrentLoad>(
        {.name = "read-current-load",
         .opcode = 0xAC,
         .manual = "A-1-4 (5); 2-3-4 (5)",
         .errata = "S39",
         .says = "Read the average motor current of the past millisecond."},
        side<ReadCurrentLoad>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<CurrentLoad>(
            bare, 2,
            septets(&CurrentLoad::current_load, 5, 2,
                    {.name = "current_load", .byte = 0, .range = {0, 4095}, .unit = "A", .scale = by_model})));
}

struct ReadCurrentPosition {
};
struct Position {
    std::uint16_t position{};
};
consteval auto row_of(const ReadCurrentPosition*)
{
    return message<ReadCurrentPosition, Position>(
        {.name = "read-current-position",
         .opcode = 0xAD,
         .manual = "A-1-4 (6); 2-3-4 (6)",
         .errata = "S39 S53 S54",
         .says = "Read the position in standard coordinates."},
        side<ReadCurrentPosition>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<Position>(bare, 2,
                       septets(&Position::position, 8, 2, {.name = "position", .byte = 0, .range = {0, 32639}})));
}

struct SetPdGain {
    std::uint8_t p_gain{};
    std::uint8_t d_gain{};
};
consteval auto row_of(const SetPdGain*)
{
    return message<SetPdGain, PdGain>(
        {.name = "set-pd-gain",
         .opcode = 0xAE,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-4 (7); 2-3-4 (7)",
         .errata = "S38 S63",
         .says = "Store the P and D gains of the position loop."},
        side<SetPdGain>(
            standard, 7,
            u8(&SetPdGain::p_gain, {.name = "p_gain", .byte = 4, .range = {0, 254}, .recommended = {1, 254}}),
            u8(&SetPdGain::d_gain, {.name = "d_gain", .byte = 5, .range = {0, 254}})),
        side<PdGain>(bare, 2, u8(&PdGain::p_gain, {.name = "p_gain", .byte = 0, .range = {0, 254}}),
                     u8(&PdGain::d_gain, {.name = "d_gain", .byte = 1, .range = {0, 254}})));
}

struct ReadPdGain {
};
consteval auto row_of(const ReadPdGain*)
{
    return message<ReadPdGain, PdGain>(
        {.name = "read-pd-gain",
         .opcode = 0xAF,
         .manual = "A-1-4 (8); 2-3-4 (8)",
         .says = "Read the P and D gains in use."},
        side<ReadPdGain>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<PdGain>(bare, 2, u8(&PdGain::p_gain, {.name = "p_gain", .byte = 0, .range = {0, 254}}),
                     u8(&PdGain::d_gain, {.name = "d_gain", .byte = 1, .range = {0, 254}})));
}

struct SetRuntimePdGain {
    std::uint8_t p_gain{};
    std::uint8_t d_gain{};
};
consteval auto row_of(const SetRuntimePdGain*)
{
    return message<SetRuntimePdGain, PdGain>(
        {.name = "set-runtime-pd-gain",
         .opcode = 0xB0,
         .access = Access::command,
         .answered_as_command = true,
         .manual = "A-1-4 (9); 2-3-4 (9)",
         .errata = "S38",
         .says = "Set the P and D gains until power-off."},
        side<SetRuntimePdGain>(
            standard, 7,
            u8(&SetRuntimePdGain::p_gain, {.name = "p_gain", .byte = 4, .range = {0, 254}, .recommended = {1, 254}}),
            u8(&SetRuntimePdGain::d_gain, {.name = "d_gain", .byte = 5, .range = {0, 254}})),
        side<PdGain>(bare, 2, u8(&PdGain::p_gain, {.name = "p_gain", .byte = 0, .range = {0, 254}}),
                     u8(&PdGain::d_gain, {.name = "d_gain", .byte = 1, .range = {0, 254}})));
}

struct SetOverload {
    std::uint16_t overload{};
};
struct Overload {
    std::uint16_t overload{};
};
consteval auto row_of(const SetOverload*)
{
    return message<SetOverload, Overload>(
        {.name = "set-overload",
         .opcode = 0xB1,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-4 (10); 2-3-4 (10)",
         .errata = "S06 S12 S44 S60",
         .says = "Store the current above which the device goes passive."},
        side<SetOverload>(standard, 7,
                          septets(&SetOverload::overload, 5, 2,
                                  {.name = "overload", .byte = 4, .range = {0, 4095}, .unit = "A", .scale = by_model})),
        side<Overload>(bare, 2,
                       septets(&Overload::overload, 5, 2,
                               {.name = "overload", .byte = 0, .range = {0, 4095}, .unit = "A", .scale = by_model})));
}

struct ReadOverload {
};
consteval auto row_of(const ReadOverload*)
{
    return message<ReadOverload, Overload>(
        {.name = "read-overload",
         .opcode = 0xB2,
         .manual = "A-1-4 (11); 2-3-4 (11)",
         .errata = "S07 S12 S60",
         .says = "Read the overload current."},
        side<ReadOverload>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<Overload>(bare, 2,
                       septets(&Overload::overload, 5, 2,
                               {.name = "overload", .byte = 0, .range = {0, 4095}, .unit = "A", .scale = by_model})));
}

struct SetBoundary {
    std::uint8_t lower_boundary{};
    std::uint8_t upper_boundary{};
};
consteval auto row_of(const SetBoundary*)
{
    return message<SetBoundary, Boundary>(
        {.name = "set-boundary",
         .opcode = 0xB3,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-4 (12); 2-3-4 (12)",
         .errata = "S08 S33 S61",
         .says = "Store the range that positions are limited to, in 254 parts of the control angle."},
        side<SetBoundary>(standard, 7,
                          u8(&SetBoundary::lower_boundary, {.name = "lower_boundary",
                                                            .byte = 4,
                                                            .range = {0, 253},
                                                            .recommended = {1, 253},
                                                            .unit = "deg",
                                                            .scale = by_model}),
                          u8(&SetBoundary::upper_boundary, {.name = "upper_boundary",
                                                            .byte = 5,
                                                            .range = {1, 254},
                                                            .recommended = {2, 254},
                                                            .unit = "deg",
                                                            .scale = by_model})),
        side<Boundary>(bare, 2,
                       u8(&Boundary::lower_boundary,
                          {.name = "lower_boundary", .byte = 0, .range = {1, 254}, .unit = "deg", .scale = by_model}),
                       u8(&Boundary::upper_boundary,
                          {.name = "upper_boundary", .byte = 1, .range = {1, 254}, .unit = "deg", .scale = by_model})));
}

struct ReadBoundary {
};
consteval auto row_of(const ReadBoundary*)
{
    return message<ReadBoundary, Boundary>(
        {.name = "read-boundary",
         .opcode = 0xB4,
         .manual = "A-1-4 (13); 2-3-4 (13)",
         .errata = "S09 S33 S61",
         .says = "Read the boundaries."},
        side<ReadBoundary>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<Boundary>(bare, 2,
                       u8(&Boundary::lower_boundary,
                          {.name = "lower_boundary", .byte = 0, .range = {1, 254}, .unit = "deg", .scale = by_model}),
                       u8(&Boundary::upper_boundary,
                          {.name = "upper_boundary", .byte = 1, .range = {1, 254}, .unit = "deg", .scale = by_model})));
}

struct SetIGain {
    std::uint8_t i_gain{};
};
struct IGain {
    std::uint8_t i_gain{};
};
consteval auto row_of(const SetIGain*)
{
    return message<SetIGain, IGain>(
        {.name = "set-i-gain",
         .opcode = 0xB5,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-4 (14); 2-3-4 (14)",
         .errata = "S10 S37",
         .says = "Store the I gain of the position loop."},
        side<SetIGain>(standard, 7, u8(&SetIGain::i_gain, {.name = "i_gain", .byte = 4, .range = {0, 254}}),
                       repeat("i_gain_repeat", 5, 4)),
        side<IGain>(bare, 2, u8(&IGain::i_gain, {.name = "i_gain", .byte = 0, .range = {0, 254}}),
                    repeat("i_gain_repeat", 1, 0)));
}

struct ReadIGain {
};
consteval auto row_of(const ReadIGain*)
{
    return message<ReadIGain, IGain>(
        {.name = "read-i-gain",
         .opcode = 0xB6,
         .manual = "A-1-4 (15); 2-3-4 (15)",
         .errata = "S11",
         .says = "Read the I gain in use."},
        side<ReadIGain>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<IGain>(bare, 2, u8(&IGain::i_gain, {.name = "i_gain", .byte = 0, .range = {0, 254}}),
                    repeat("i_gain_repeat", 1, 0)));
}

struct SetRuntimeIGain {
    std::uint8_t i_gain{};
};
consteval auto row_of(const SetRuntimeIGain*)
{
    return message<SetRuntimeIGain, IGain>(
        {.name = "set-runtime-i-gain",
         .opcode = 0xB7,
         .access = Access::command,
         .answered_as_command = true,
         .manual = "A-1-4 (16); 2-3-4 (16)",
         .errata = "S37",
         .says = "Set the I gain until power-off."},
        side<SetRuntimeIGain>(
            standard, 7,
            u8(&SetRuntimeIGain::i_gain, {.name = "i_gain", .byte = 4, .range = {0, 254}, .recommended = {0, 10}}),
            repeat("i_gain_repeat", 5, 4)),
        side<IGain>(bare, 2,
                    u8(&IGain::i_gain, {.name = "i_gain", .byte = 0, .range = {0, 254}, .recommended = {0, 10}}),
                    repeat("i_gain_repeat", 1, 0)));
}

struct SetDriveMode {
    std::uint8_t response_level{};
    bool reverse{};
};
struct DriveMode {
    std::uint8_t response_level{};
    bool reverse{};
};
consteval auto row_of(const SetDriveMode*)
{
    return message<SetDriveMode, DriveMode>(
        {.name = "set-drive-mode",
         .opcode = 0xB8,
         .access = Access::flash,
         .moves = true,
         .answered_as_command = true,
         .manual = "A-1-4 (17); 2-3-4 (17)",
         .errata = "S13 S45 S46 S47",
         .says = "Store which commands are answered and whether the direction is reversed."},
        side<SetDriveMode>(
            standard, 7,
            bits(&SetDriveMode::response_level, 5, 4,
                 {.name = "response_level", .byte = 4, .range = {0, 2}, .says = "0 answers reads only, 1 all, 2 none"}),
            bits(&SetDriveMode::reverse, 0, 0, {.name = "reverse", .byte = 4, .range = {0, 1}}),
            reserved("reserved_7_6", 4, 7, 6), reserved("reserved_3_1", 4, 3, 1), repeat("drive_mode_repeat", 5, 4)),
        side<DriveMode>(
            bare, 2,
            bits(&DriveMode::response_level, 5, 4,
                 {.name = "response_level", .byte = 0, .range = {0, 2}, .says = "0 answers reads only, 1 all, 2 none"}),
            bits(&DriveMode::reverse, 0, 0, {.name = "reverse", .byte = 0, .range = {0, 1}}),
            reserved("reserved_7_6", 0, 7, 6), reserved("reserved_3_1", 0, 3, 1), repeat("drive_mode_repeat", 1, 0)));
}

struct ReadDriveMode {
};
consteval auto row_of(const ReadDriveMode*)
{
    return message<ReadDriveMode, DriveMode>(
        {.name = "read-drive-mode",
         .opcode = 0xB9,
         .manual = "A-1-4 (18); 2-3-4 (18)",
         .errata = "S46",
         .says = "Read response level and direction."},
        side<ReadDriveMode>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<DriveMode>(
            bare, 2,
            bits(&DriveMode::response_level, 5, 4,
                 {.name = "response_level", .byte = 0, .range = {0, 2}, .says = "0 answers reads only, 1 all, 2 none"}),
            bits(&DriveMode::reverse, 0, 0, {.name = "reverse", .byte = 0, .range = {0, 1}}),
            reserved("reserved_7_6", 0, 7, 6), reserved("reserved_3_1", 0, 3, 1), repeat("drive_mode_repeat", 1, 0)));
}

struct SetAvgTorque {
    std::uint16_t avg_torque{};
};
struct AvgTorque {
    std::uint16_t avg_torque{};
};
consteval auto row_of(const SetAvgTorque*)
{
    return message<SetAvgTorque, AvgTorque>(
        {.name = "set-avg-torque",
         .opcode = 0xBA,
         .access = Access::flash,
         .answered_as_command = true,
         .manual = "A-1-4 (19); 2-3-4 (19)",
         .errata = "S12 S16 S35 S84",
         .says = "Store the torque of position control; 2000 is the full capacity, 0 does not move."},
        side<SetAvgTorque>(standard, 7,
                           septets(&SetAvgTorque::avg_torque, 5, 2,
                                   {.name = "avg_torque", .byte = 4, .range = {0, 4095}, .recommended = {0, 2000}})),
        side<AvgTorque>(bare, 2,
                        septets(&AvgTorque::avg_torque, 5, 2, {.name = "avg_torque", .byte = 0, .range = {0, 2000}})));
}

struct ReadAvgTorque {
};
consteval auto row_of(const ReadAvgTorque*)
{
    return message<ReadAvgTorque, AvgTorque>(
        {.name = "read-avg-torque",
         .opcode = 0xBB,
         .manual = "A-1-4 (20); 2-3-4 (20)",
         .errata = "S12 S16 S35",
         .says = "Read the torque of position control."},
        side<ReadAvgTorque>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<AvgTorque>(bare, 2,
                        septets(&AvgTorque::avg_torque, 5, 2, {.name = "avg_torque", .byte = 0, .range = {0, 2000}})));
}

struct ReadInputVoltage {
};
struct InputVoltage {
    std::uint16_t input_voltage{};
};
consteval auto row_of(const ReadInputVoltage*)
{
    return message<ReadInputVoltage, InputVoltage>(
        {.name = "read-input-voltage",
         .opcode = 0xBC,
         .manual = "A-1-4 (21); 2-3-4 (21)",
         .errata = "S12 S14 S16",
         .says = "Read the supply voltage."},
        side<ReadInputVoltage>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<InputVoltage>(bare, 2,
                           septets(&InputVoltage::input_voltage, 5, 2,
                                   {.name = "input_voltage",
                                    .byte = 0,
                                    .range = {0, 4095},
                                    .unit = "V",
                                    .scale = by_model,
                                    .offset = 0.65})));
}

struct WriteExternalPort {
    bool led_red{};
    bool led_blue{};
    bool do1{};
    bool do2{};
};
consteval auto row_of(const WriteExternalPort*)
{
    return message<WriteExternalPort, ExternalPort>(
        {.name = "write-external-port",
         .opcode = 0xBE,
         .access = Access::command,
         .answered_as_command = true,
         .restriction = encoder_models,
         .manual = "A-1-5 (1); 2-3-5 (1)",
         .errata = "S16 S18 S49",
         .says = "Switch the LEDs and the two digital outputs."},
        side<WriteExternalPort>(
            standard, 7, bits(&WriteExternalPort::led_red, 0, 0, {.name = "led_red", .byte = 4, .range = {0, 1}}),
            bits(&WriteExternalPort::led_blue, 1, 1, {.name = "led_blue", .byte = 4, .range = {0, 1}}),
            bits(&WriteExternalPort::do1, 2, 2, {.name = "do1", .byte = 4, .range = {0, 1}}),
            bits(&WriteExternalPort::do2, 3, 3, {.name = "do2", .byte = 4, .range = {0, 1}}),
            reserved("reserved_7_4", 4, 7, 4), repeat("port_repeat", 5, 4)),
        side<ExternalPort>(bare, 2, bits(&ExternalPort::led_red, 0, 0, {.name = "led_red", .byte = 0, .range = {0, 1}}),
                           bits(&ExternalPort::led_blue, 1, 1, {.name = "led_blue", .byte = 0, .range = {0, 1}}),
                           bits(&ExternalPort::do1, 2, 2, {.name = "do1", .byte = 0, .range = {0, 1}}),
                           bits(&ExternalPort::do2, 3, 3, {.name = "do2", .byte = 0, .range = {0, 1}}),
                           reserved("reserved_7_4", 0, 7, 4), repeat("port_repeat", 1, 0)));
}

struct ReadExternalAd {
};
consteval auto row_of(const ReadExternalAd*)
{
    return message<ReadExternalAd, ExternalAd>(
        {.name = "read-external-ad",
         .opcode = 0xBF,
         .restriction = encoder_models,
         .manual = "A-1-5 (2); 2-3-5 (2)",
         .errata = "S16 S72",
         .says = "Read the analogue input of the external port."},
        side<ReadExternalAd>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<ExternalAd>(
            bare, 2,
            septets(&ExternalAd::external_ad, 5, 2,
                    {.name = "external_ad", .byte = 0, .range = {0, 4095}, .unit = "V", .scale = 0.001343})));
}

struct WriteMotionData {
    std::uint8_t motion_count{};
    std::array<wire::Pair, 8> instructions{};
};
consteval auto row_of(const WriteMotionData*)
{
    return message<WriteMotionData, MotionCount>(
        {.name = "write-motion-data",
         .opcode = 0xC0,
         .access = Access::flash,
         .moves = true,
         .answered_as_command = true,
         .manual = "A-1-5 (3); 2-3-5 (3)",
         .errata = "S16 S17 S64 S65 S81",
         .says = "Store a self-running program of up to eight instructions; none switches it off."},
        side<WriteMotionData>(standard, 6,
                              u8(&WriteMotionData::motion_count, {.name = "motion_count", .byte = 4, .range = {0, 8}}),
                              pairs(&WriteMotionData::instructions, &WriteMotionData::motion_count,
                                    {.name = "instructions",
                                     .byte = 5,
                                     .range = {0, 254},
                                     .says = "command and data byte of each instruction"})),
        side<MotionCount>(bare, 2, u8(&MotionCount::motion_count, {.name = "motion_count", .byte = 0, .range = {0, 8}}),
                          repeat("motion_count_repeat", 1, 0)));
}

struct ReadMotionData {
};
consteval auto row_of(const ReadMotionData*)
{
    return message<ReadMotionData, MotionCount>(
        {.name = "read-motion-data",
         .opcode = 0xC1,
         .manual = "A-1-5 (4); 2-3-5 (4)",
         .errata = "S16",
         .says = "Read how many instructions the stored program has."},
        side<ReadMotionData>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<MotionCount>(bare, 2, u8(&MotionCount::motion_count, {.name = "motion_count", .byte = 0, .range = {0, 8}}),
                          repeat("motion_count_repeat", 1, 0)));
}

struct Ping {
};
consteval auto row_of(const Ping*)
{
    return message<Ping, Identity>({.name = "ping",
                                    .opcode = 0xC2,
                                    .manual = "A-1-5 (5); 2-3-5 (5)",
                                    .errata = "S16 S51 S45",
                                    .says = "Ask a device whether it is there."},
                                   side<Ping>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
                                   side<Identity>(bare, 2,
                                                  u8(&Identity::id, {.name = "id", .byte = 0, .range = {0, 254}}),
                                                  repeat("id_repeat", 1, 0)));
}

struct ReadFirmwareVersion {
};
struct FirmwareVersion {
    std::uint8_t model_number{};
    std::uint8_t fw_version{};
};
consteval auto row_of(const ReadFirmwareVersion*)
{
    return message<ReadFirmwareVersion, FirmwareVersion>(
        {.name = "read-firmware-version",
         .opcode = 0xC3,
         .manual = "A-1-5 (6); 2-3-5 (6)",
         .errata = "S52",
         .says = "Read model number and firmware version."},
        side<ReadFirmwareVersion>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<FirmwareVersion>(
            bare, 2, u8(&FirmwareVersion::model_number, {.name = "model_number", .byte = 0, .labels = model_numbers}),
            u8(&FirmwareVersion::fw_version, {.name = "fw_version", .byte = 1})));
}

struct OffsetControl {
    std::uint8_t offset_control{};
};
struct Offset {
    std::uint8_t offset_control{};
};
consteval auto row_of(const OffsetControl*)
{
    return message<OffsetControl, Offset>(
        {.name = "offset-control",
         .opcode = 0xC4,
         .access = Access::command,
         .moves = true,
         .answered_as_command = true,
         .restriction = encoder_models,
         .manual = "A-2 only ('zero position setting')",
         .errata = "S50",
         .says = "Make the present position the zero, or take that back; named only by the code listing."},
        side<OffsetControl>(standard, 7,
                            u8(&OffsetControl::offset_control, {.name = "offset_control", .byte = 4, .range = {0, 1}}),
                            repeat("offset_control_repeat", 5, 4)),
        side<Offset>(bare, 2, u8(&Offset::offset_control, {.name = "offset_control", .byte = 0, .range = {0, 1}}),
                     repeat("offset_control_repeat", 1, 0)));
}

struct ReadTemperatureError {
};
struct TemperatureError {
    std::uint8_t temp_error{};
};
consteval auto row_of(const ReadTemperatureError*)
{
    return message<ReadTemperatureError, TemperatureError>(
        {.name = "read-temperature-error",
         .opcode = 0xC5,
         .manual = "A-1-5 (7) 'Read Temp Error'; 2-3-5 (7) 'Load Overheat status'",
         .errata = "S19 S66",
         .says = "Read whether the device has stopped because it is hotter than 65 degC."},
        side<ReadTemperatureError>(standard, 7, reserved("dont_care_1", 4), reserved("dont_care_2", 5)),
        side<TemperatureError>(bare, 2,
                               u8(&TemperatureError::temp_error,
                                  {.name = "temp_error", .byte = 0, .range = {0, 1}, .labels = temperature_states}),
                               repeat("temp_error_repeat", 1, 0)));
}

struct SpecialControl {
    Mode mode{};
    std::uint16_t wheel_speed{};
};
struct ControlMode {
    std::uint8_t id{};
    Mode mode{};
};
consteval auto row_of(const SpecialControl*)
{
    return message<SpecialControl, ControlMode>(
        {.name = "special-control",
         .opcode = 0xC7,
         .access = Access::command,
         .moves = true,
         .answered_as_command = true,
         .manual = "A-1-6 (1); 2-3-6 (1)",
         .errata = "S41",
         .says = "Switch between position control, passive, brake and wheel."},
        side<SpecialControl>(
            standard, 7,
            bits(&SpecialControl::mode, 7, 4, {.name = "mode", .byte = 4, .range = {0, 3}, .labels = modes}),
            septets(
                &SpecialControl::wheel_speed, 4, 2,
                {.name = "wheel_speed",
                 .byte = 4,
                 .shares_top = true,
                 .lenient = 1,
                 .range = {0, 2000},
                 .says = "0 … 999 clockwise and 1000 … 2000 counter-clockwise in 0.1 % PWM duty; 0 and 1000 stop"})),
        side<ControlMode>(bare, 2, u8(&ControlMode::id, {.name = "id", .byte = 0, .range = {0, 254}}),
                          u8(&ControlMode::mode, {.name = "mode", .byte = 1, .range = {0, 3}, .labels = modes})));
}

struct PositionControl {
    std::uint16_t target_position{};
};
consteval auto row_of(const PositionControl*)
{
    return message<PositionControl, Position>(
        {.name = "position-control",
         .opcode = 0xC8,
         .access = Access::command,
         .moves = true,
         .answered_as_command = true,
         .manual = "A-1-6 (2); 2-3-6 (2)",
         .errata = "S39 S53 S54 S55",
         .says = "Go to a position in standard coordinates."},
        side<PositionControl>(standard, 7,
                              septets(&PositionControl::target_position, 8, 2,
                                      {.name = "target_position", .byte = 4, .range = {0, 32639}})),
        side<Position>(bare, 2,
                       septets(&Position::position, 8, 2, {.name = "position", .byte = 0, .range = {0, 32639}})));
}

struct PrecisePositionControl {
    std::uint32_t target_position{};
};
struct PrecisePosition {
    std::uint32_t position{};
};
consteval auto row_of(const PrecisePositionControl*)
{
    return message<PrecisePositionControl, PrecisePosition>(
        {.name = "precise-position-control",
         .opcode = 0xCA,
         .access = Access::command,
         .moves = true,
         .answered_as_command = true,
         .restriction = encoder_models,
         .manual = "A-1-6 (3); 2-3-6 (3)",
         .errata = "S20 S22 S23 S56 S41",
         .says = "Go to a position in precise coordinates."},
        side<PrecisePositionControl>(standard, 8,
                                     septets(&PrecisePositionControl::target_position, 5, 3,
                                             {.name = "target_position", .byte = 4, .lenient = 1})),
        side<PrecisePosition>(bare, 3, septets(&PrecisePosition::position, 5, 3, {.name = "position", .byte = 0})));
}

struct ReadPrecisePosition {
};
consteval auto row_of(const ReadPrecisePosition*)
{
    return message<ReadPrecisePosition, PrecisePosition>(
        {.name = "read-precise-position",
         .opcode = 0xCB,
         .restriction = encoder_models,
         .manual = "A-1-6 (4); 2-3-6 '(5) Load Precise Position Control'",
         .errata = "S21 S23 S56",
         .says = "Read the position in precise coordinates."},
        side<ReadPrecisePosition>(standard, 8, reserved("dont_care_1", 4), reserved("dont_care_2", 5),
                                  reserved("dont_care_3", 6)),
        side<PrecisePosition>(bare, 3, septets(&PrecisePosition::position, 5, 3, {.name = "position", .byte = 0})));
}

/// Every message of the manual.
using ManualMessages =
    MessageList<QuickPositionControl, QuickReadStatus, QuickPassiveMode, QuickWheelMode, QuickBrakeMode,
                QuickSetBaudRate, QuickSetRuntimePdGain, QuickSetId, QuickSetOverload, QuickReadOverload,
                QuickSetBoundary, QuickReadBoundary, QuickWriteExternalPort, QuickReadExternalAd, QuickWriteMotionData,
                QuickReadMotionData, SetId, SetBaudRate, SetCtrlSpeed, ReadCtrlSpeed, SetCtrlTorque, ReadCtrlTorque,
                SetCtrlAccel, ReadCtrlAccel, SetCtrlDecel, ReadCtrlDecel, ReadCurrentSpeed, ReadCurrentAccel,
                ReadCurrentLoad, ReadCurrentPosition, SetPdGain, ReadPdGain, SetRuntimePdGain, SetOverload,
                ReadOverload, SetBoundary, ReadBoundary, SetIGain, ReadIGain, SetRuntimeIGain, SetDriveMode,
                ReadDriveMode, SetAvgTorque, ReadAvgTorque, ReadInputVoltage, WriteExternalPort, ReadExternalAd,
                WriteMotionData, ReadMotionData, Ping, ReadFirmwareVersion, OffsetControl, ReadTemperatureError,
                SpecialControl, PositionControl, PrecisePositionControl, ReadPrecisePosition>;
inline constexpr auto manual_messages = catalogue(ManualMessages{});

} // namespace sinew::sam
