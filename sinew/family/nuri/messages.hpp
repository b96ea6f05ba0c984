#pragma once
#include "sinew/wire/message.hpp"

#include <cstdint>

/// Nuri: 24 requests and 10 replies. Source: the RS-485 protocol in nuri.txt; resolutions named in each row (README.md
/// of this folder). Bytes count from the first header byte; multi-byte fields are big endian (N11).
namespace sinew::nuri {

using namespace wire;

// ---- words for raw values ----

enum class Rotation : std::uint8_t { counter_clockwise, clockwise };
inline constexpr Label rotations[] = {{0, "CCW"}, {1, "CW"}};

/// On is 0 (N22).
enum class Control : std::uint8_t { on, off };
inline constexpr Label controls[] = {{0, "on"}, {1, "off"}};

enum class PositionMode : std::uint8_t { absolute, relative };
inline constexpr Label position_modes[] = {{0, "absolute"}, {1, "relative"}};

/// L181-198.
inline constexpr Label baud_codes[] = {{0, "110"},     {1, "300"},     {2, "600"},     {3, "1200"},    {4, "2400"},
                                       {5, "4800"},    {6, "9600"},    {7, "14400"},   {8, "19200"},   {9, "28800"},
                                       {10, "38400"},  {11, "57600"},  {12, "76800"},  {13, "115200"}, {14, "230400"},
                                       {15, "250000"}, {16, "500000"}, {17, "1000000"}};

// ---- framing (L5-7, L180; N09, N10) ----

consteval Field id_byte(std::int64_t highest)
{
    return {.name = "id", .byte = 2, .kind = Kind::address, .range = {0, highest}};
}

inline constexpr Field header_0 = constant("header_0", 0, 0xFF);
inline constexpr Field header_1 = constant("header_1", 1, 0xFE);
inline constexpr Field size_byte{.name = "size", .byte = 3, .kind = Kind::size};
inline constexpr Field sum{.name = "checksum", .byte = 4, .kind = Kind::checksum};
inline constexpr Field mode_byte{.name = "mode", .byte = 5, .kind = Kind::opcode};

inline constexpr Field control_fields[] = {header_0, header_1, id_byte(255), size_byte, sum, mode_byte};
inline constexpr Field feedback_fields[] = {header_0, header_1, id_byte(254), size_byte, sum, mode_byte};

/// Settings and motion; id 255 is all devices. Never answered (N12).
inline constexpr Layout control{
    .name = "control", .checksum = Checksum::not_sum, .fields = control_fields, .ids = {0, 255}};
/// Feedback requests and their answers; no broadcast (N13).
inline constexpr Layout feedback{
    .name = "feedback", .checksum = Checksum::not_sum, .fields = feedback_fields, .ids = {0, 254}};

struct ReplyPing {
};
consteval auto row_of(const ReplyPing*)
{
    return message<Nothing, ReplyPing>(
        {.name = "reply-ping", .opcode = 0xD0, .manual = "15", .says = "The device is there."}, no_side,
        side<ReplyPing>(feedback, 6));
}

struct ReplyPositionFeedback {
    Rotation position_direction{};
    std::uint16_t position{};
    std::uint16_t speed{};
    std::uint8_t current{};
};
consteval auto row_of(const ReplyPositionFeedback*)
{
    return message<Nothing, ReplyPositionFeedback>(
        {.name = "reply-position-feedback",
         .opcode = 0xD1,
         .manual = "16",
         .errata = "N20 N17 N35",
         .says = "Position with its direction, speed without one, and current."},
        no_side,
        side<ReplyPositionFeedback>(
            feedback, 12,
            u8(&ReplyPositionFeedback::position_direction,
               {.name = "position_direction", .byte = 6, .range = {0, 1}, .labels = rotations}),
            u16_be(&ReplyPositionFeedback::position,
                   {.name = "position", .byte = 7, .range = {0, 65533}, .unit = "deg", .scale = 0.01}),
            u16_be(&ReplyPositionFeedback::speed,
                   {.name = "speed", .byte = 9, .range = {0, 65533}, .unit = "RPM", .scale = 0.1}),
            u8(&ReplyPositionFeedback::current,
               {.name = "current", .byte = 11, .range = {0, 254}, .unit = "A", .scale = 0.1})));
}

struct ReplySpeedFeedback {
    Rotation speed_direction{};
    std::uint16_t speed{};
    std::uint16_t position{};
    std::uint8_t current{};
};
consteval auto row_of(const ReplySpeedFeedback*)
{
    return message<Nothing, ReplySpeedFeedback>(
        {.name = "reply-speed-feedback",
         .opcode = 0xD2,
         .manual = "17",
         .errata = "N05 N06 N20 N35",
         .says = "Speed with its direction, position without one, and current."},
        no_side,
        side<ReplySpeedFeedback>(
            feedback, 12,
            u8(&ReplySpeedFeedback::speed_direction,
               {.name = "speed_direction", .byte = 6, .range = {0, 1}, .labels = rotations}),
            u16_be(&ReplySpeedFeedback::speed,
                   {.name = "speed", .byte = 7, .range = {0, 65533}, .unit = "RPM", .scale = 0.1}),
            u16_be(&ReplySpeedFeedback::position,
                   {.name = "position", .byte = 9, .range = {0, 65533}, .unit = "deg", .scale = 0.1}),
            u8(&ReplySpeedFeedback::current,
               {.name = "current", .byte = 11, .range = {0, 254}, .unit = "A", .scale = 0.1})));
}

struct ReplyPositionControllerFeedback {
    std::uint8_t position_kp{};
    std::uint8_t position_ki{};
    std::uint8_t position_kd{};
    std::uint8_t position_rated_current{};
};
consteval auto row_of(const ReplyPositionControllerFeedback*)
{
    return message<Nothing, ReplyPositionControllerFeedback>(
        {.name = "reply-position-controller-feedback",
         .opcode = 0xD3,
         .manual = "18",
         .errata = "N03",
         .says = "Gains and rated current of the position controller."},
        no_side,
        side<ReplyPositionControllerFeedback>(
            feedback, 10,
            u8(&ReplyPositionControllerFeedback::position_kp, {.name = "position_kp", .byte = 6, .range = {1, 254}}),
            u8(&ReplyPositionControllerFeedback::position_ki, {.name = "position_ki", .byte = 7, .range = {0, 254}}),
            u8(&ReplyPositionControllerFeedback::position_kd, {.name = "position_kd", .byte = 8, .range = {0, 254}}),
            u8(&ReplyPositionControllerFeedback::position_rated_current,
               {.name = "position_rated_current",
                .byte = 9,
                .range = {1, 255},
                .unit = "A",
                .scale = 0.1,
                .says = "the upper limit is the rated current of the product"})));
}

struct ReplySpeedControllerFeedback {
    std::uint8_t speed_kp{};
    std::uint8_t speed_ki{};
    std::uint8_t speed_kd{};
    std::uint8_t speed_rated_current{};
};
consteval auto row_of(const ReplySpeedControllerFeedback*)
{
    return message<Nothing, ReplySpeedControllerFeedback>(
        {.name = "reply-speed-controller-feedback",
         .opcode = 0xD4,
         .manual = "19",
         .errata = "N03",
         .says = "Gains and rated current of the speed controller."},
        no_side,
        side<ReplySpeedControllerFeedback>(
            feedback, 10,
            u8(&ReplySpeedControllerFeedback::speed_kp, {.name = "speed_kp", .byte = 6, .range = {1, 254}}),
            u8(&ReplySpeedControllerFeedback::speed_ki, {.name = "speed_ki", .byte = 7, .range = {0, 254}}),
            u8(&ReplySpeedControllerFeedback::speed_kd, {.name = "speed_kd", .byte = 8, .range = {0, 254}}),
            u8(&ReplySpeedControllerFeedback::speed_rated_current,
               {.name = "speed_rated_current",
                .byte = 9,
                .range = {1, 255},
                .unit = "A",
                .scale = 0.1,
                .says = "the upper limit is the rated current of the product"})));
}

struct ReplyResponseTimeFeedback {
    std::uint8_t response_time{};
};
consteval auto row_of(const ReplyResponseTimeFeedback*)
{
    return message<Nothing, ReplyResponseTimeFeedback>(
        {.name = "reply-response-time-feedback",
         .opcode = 0xD5,
         .manual = "20",
         .says = "How long the device waits before it answers."},
        no_side,
        side<ReplyResponseTimeFeedback>(
            feedback, 7,
            u8(&ReplyResponseTimeFeedback::response_time,
               {.name = "response_time", .byte = 6, .range = {0, 254}, .unit = "us", .scale = 100})));
}

struct ReplyGearRatioFeedback {
    std::uint16_t gear_ratio{};
};
consteval auto row_of(const ReplyGearRatioFeedback*)
{
    return message<Nothing, ReplyGearRatioFeedback>(
        {.name = "reply-gear-ratio-feedback",
         .opcode = 0xD6,
         .manual = "21",
         .errata = "N05 N20",
         .says = "Ratio of the external gear."},
        no_side,
        side<ReplyGearRatioFeedback>(
            feedback, 8,
            u16_be(&ReplyGearRatioFeedback::gear_ratio,
                   {.name = "gear_ratio", .byte = 6, .range = {1, 65533}, .unit = "ratio", .scale = 0.1})));
}

struct ReplyControlOnOffFeedback {
    Control control{};
};
consteval auto row_of(const ReplyControlOnOffFeedback*)
{
    return message<Nothing, ReplyControlOnOffFeedback>(
        {.name = "reply-control-on-off-feedback", .opcode = 0xD7, .manual = "22", .says = "Whether the control is on."},
        no_side,
        side<ReplyControlOnOffFeedback>(feedback, 7,
                                        u8(&ReplyControlOnOffFeedback::control,
                                           {.name = "control", .byte = 6, .range = {0, 1}, .labels = controls})));
}

struct ReplyPositionModeFeedback {
    PositionMode position_mode{};
};
consteval auto row_of(const ReplyPositionModeFeedback*)
{
    return message<Nothing, ReplyPositionModeFeedback>(
        {.name = "reply-position-mode-feedback",
         .opcode = 0xD8,
         .manual = "23",
         .errata = "N07",
         .says = "Whether positions are absolute or relative."},
        no_side,
        side<ReplyPositionModeFeedback>(
            feedback, 7,
            u8(&ReplyPositionModeFeedback::position_mode,
               {.name = "position_mode", .byte = 6, .range = {0, 1}, .labels = position_modes})));
}

struct ReplyFirmwareVersionFeedback {
    std::uint8_t version{};
};
consteval auto row_of(const ReplyFirmwareVersionFeedback*)
{
    return message<Nothing, ReplyFirmwareVersionFeedback>(
        {.name = "reply-firmware-version-feedback", .opcode = 0xFD, .manual = "24", .says = "Firmware version."},
        no_side,
        side<ReplyFirmwareVersionFeedback>(
            feedback, 7,
            u8(&ReplyFirmwareVersionFeedback::version, {.name = "version", .byte = 6, .range = {0, 254}})));
}

struct PositionSpeedControl {
    Rotation position_direction{};
    std::uint16_t position{};
    std::uint16_t speed{};
};
consteval auto row_of(const PositionSpeedControl*)
{
    return message<PositionSpeedControl, Nothing>(
        {.name = "position-speed-control",
         .opcode = 0x01,
         .access = Access::command,
         .moves = true,
         .broadcast = true,
         .manual = "1",
         .errata = "N04 N16 N17 N18 N35",
         .says = "Go to a position at a given speed."},
        side<PositionSpeedControl>(
            control, 11,
            u8(&PositionSpeedControl::position_direction,
               {.name = "position_direction", .byte = 6, .range = {0, 1}, .labels = rotations}),
            u16_be(&PositionSpeedControl::position,
                   {.name = "position", .byte = 7, .range = {0, 65533}, .unit = "deg", .scale = 0.01}),
            u16_be(&PositionSpeedControl::speed,
                   {.name = "speed", .byte = 9, .range = {1, 65533}, .unit = "RPM", .scale = 0.1})),
        no_side);
}

struct AccelPositionControl {
    Rotation position_direction{};
    std::uint16_t position{};
    std::uint8_t arrival_time{};
};
consteval auto row_of(const AccelPositionControl*)
{
    return message<AccelPositionControl, Nothing>(
        {.name = "accel-position-control",
         .opcode = 0x02,
         .access = Access::command,
         .moves = true,
         .broadcast = true,
         .manual = "2",
         .errata = "N04 N16 N23 N17 N35",
         .says = "Reach a position in a given time."},
        side<AccelPositionControl>(
            control, 10,
            u8(&AccelPositionControl::position_direction,
               {.name = "position_direction", .byte = 6, .range = {0, 1}, .labels = rotations}),
            u16_be(&AccelPositionControl::position,
                   {.name = "position", .byte = 7, .range = {0, 65533}, .unit = "deg", .scale = 0.01}),
            u8(&AccelPositionControl::arrival_time,
               {.name = "arrival_time", .byte = 9, .range = {1, 255}, .unit = "s", .scale = 0.1})),
        no_side);
}

struct AccelSpeedControl {
    Rotation speed_direction{};
    std::uint16_t speed{};
    std::uint8_t arrival_time{};
};
consteval auto row_of(const AccelSpeedControl*)
{
    return message<AccelSpeedControl, Nothing>(
        {.name = "accel-speed-control",
         .opcode = 0x03,
         .access = Access::command,
         .moves = true,
         .broadcast = true,
         .manual = "3",
         .errata = "N04 N23 N35",
         .says = "Reach a speed in a given time."},
        side<AccelSpeedControl>(control, 10,
                                u8(&AccelSpeedControl::speed_direction,
                                   {.name = "speed_direction", .byte = 6, .range = {0, 1}, .labels = rotations}),
                                u16_be(&AccelSpeedControl::speed,
                                       {.name = "speed", .byte = 7, .range = {0, 65533}, .unit = "RPM", .scale = 0.1}),
                                u8(&AccelSpeedControl::arrival_time,
                                   {.name = "arrival_time", .byte = 9, .range = {1, 255}, .unit = "s", .scale = 0.1})),
        no_side);
}

struct SetPositionController {
    std::uint8_t position_kp{};
    std::uint8_t position_ki{};
    std::uint8_t position_kd{};
    std::uint8_t position_rated_current{};
};
consteval auto row_of(const SetPositionController*)
{
    return message<SetPositionController, Nothing>(
        {.name = "set-position-controller",
         .opcode = 0x04,
         .access = Access::flash,
         .broadcast = true,
         .manual = "4",
         .errata = "N03 N14 N19",
         .says = "Store the gains and the rated current of the position controller."},
        side<SetPositionController>(
            control, 10, u8(&SetPositionController::position_kp, {.name = "position_kp", .byte = 6, .range = {1, 254}}),
            u8(&SetPositionController::position_ki, {.name = "position_ki", .byte = 7, .range = {0, 254}}),
            u8(&SetPositionController::position_kd, {.name = "position_kd", .byte = 8, .range = {0, 254}}),
            u8(&SetPositionController::position_rated_current,
               {.name = "position_rated_current",
                .byte = 9,
                .range = {1, 255},
                .unit = "A",
                .scale = 0.1,
                .says = "the upper limit is the rated current of the product"})),
        no_side);
}

struct SetSpeedController {
    std::uint8_t speed_kp{};
    std::uint8_t speed_ki{};
    std::uint8_t speed_kd{};
    std::uint8_t speed_rated_current{};
};
consteval auto row_of(const SetSpeedController*)
{
    return message<SetSpeedController, Nothing>(
        {.name = "set-speed-controller",
         .opcode = 0x05,
         .access = Access::flash,
         .broadcast = true,
         .manual = "5",
         .errata = "N03 N14 N19",
         .says = "Store the gains and the rated current of the speed controller."},
        side<SetSpeedController>(control, 10,
                                 u8(&SetSpeedController::speed_kp, {.name = "speed_kp", .byte = 6, .range = {1, 254}}),
                                 u8(&SetSpeedController::speed_ki, {.name = "speed_ki", .byte = 7, .range = {0, 254}}),
                                 u8(&SetSpeedController::speed_kd, {.name = "speed_kd", .byte = 8, .range = {0, 254}}),
                                 u8(&SetSpeedController::speed_rated_current,
                                    {.name = "speed_rated_current",
                                     .byte = 9,
                                     .range = {1, 255},
                                     .unit = "A",
                                     .scale = 0.1,
                                     .says = "the upper limit is the rated current of the product"})),
        no_side);
}

struct SetId {
    std::uint8_t new_id{};
};
consteval auto row_of(const SetId*)
{
    return message<SetId, Nothing>(
        {.name = "set-id",
         .opcode = 0x06,
         .access = Access::flash,
         .broadcast = true,
         .manual = "6",
         .errata = "N13 N14 N15",
         .says = "Store another id."},
        side<SetId>(control, 7, u8(&SetId::new_id, {.name = "new_id", .byte = 6, .range = {0, 254}})), no_side);
}

struct SetBaudRate {
    std::uint8_t baud_code{};
};
consteval auto row_of(const SetBaudRate*)
{
    return message<SetBaudRate, Nothing>(
        {.name = "set-baud-rate",
         .opcode = 0x07,
         .access = Access::flash,
         .broadcast = true,
         .manual = "7",
         .errata = "N14 N15",
         .says = "Store another bit rate."},
        side<SetBaudRate>(
            control, 7,
            u8(&SetBaudRate::baud_code, {.name = "baud_code", .byte = 6, .range = {0, 17}, .labels = baud_codes})),
        no_side);
}

struct SetResponseTime {
    std::uint8_t response_time{};
};
consteval auto row_of(const SetResponseTime*)
{
    return message<SetResponseTime, Nothing>(
        {.name = "set-response-time",
         .opcode = 0x08,
         .access = Access::flash,
         .broadcast = true,
         .manual = "8",
         .errata = "N14 N21",
         .says = "Store how long the device waits before it answers."},
        side<SetResponseTime>(control, 7,
                              u8(&SetResponseTime::response_time,
                                 {.name = "response_time", .byte = 6, .range = {0, 254}, .unit = "us", .scale = 100})),
        no_side);
}

struct SetExternalGearRatio {
    std::uint16_t gear_ratio{};
};
consteval auto row_of(const SetExternalGearRatio*)
{
    return message<SetExternalGearRatio, Nothing>(
        {.name = "set-external-gear-ratio",
         .opcode = 0x09,
         .access = Access::flash,
         .broadcast = true,
         .manual = "9",
         .errata = "N05 N14 N33",
         .says = "Store the ratio of a gear behind the actuator."},
        side<SetExternalGearRatio>(
            control, 8,
            u16_be(&SetExternalGearRatio::gear_ratio,
                   {.name = "gear_ratio", .byte = 6, .range = {1, 65533}, .unit = "ratio", .scale = 0.1})),
        no_side);
}

struct SetControlOnOff {
    Control control{};
};
consteval auto row_of(const SetControlOnOff*)
{
    return message<SetControlOnOff, Nothing>(
        {.name = "set-control-on-off",
         .opcode = 0x0A,
         .access = Access::flash,
         .moves = true,
         .broadcast = true,
         .manual = "10",
         .errata = "N01 N14 N22",
         .says = "Switch the control on or off; 0 is on."},
        side<SetControlOnOff>(
            control, 7,
            u8(&SetControlOnOff::control, {.name = "control", .byte = 6, .range = {0, 1}, .labels = controls})),
        no_side);
}

struct SetPositionControlMode {
    PositionMode position_mode{};
};
consteval auto row_of(const SetPositionControlMode*)
{
    return message<SetPositionControlMode, Nothing>(
        {.name = "set-position-control-mode",
         .opcode = 0x0B,
         .access = Access::flash,
         .broadcast = true,
         .manual = "11",
         .errata = "N14 N16",
         .says = "Store whether positions are absolute or relative."},
        side<SetPositionControlMode>(
            control, 7,
            u8(&SetPositionControlMode::position_mode,
               {.name = "position_mode", .byte = 6, .range = {0, 1}, .labels = position_modes})),
        no_side);
}

struct ResetPosition {
};
consteval auto row_of(const ResetPosition*)
{
    return message<ResetPosition, Nothing>({.name = "reset-position",
                                            .opcode = 0x0C,
                                            .access = Access::command,
                                            .moves = true,
                                            .broadcast = true,
                                            .manual = "12",
                                            .errata = "N25",
                                            .says = "Make the present position zero."},
                                           side<ResetPosition>(control, 6), no_side);
}

struct FactoryReset {
};
consteval auto row_of(const FactoryReset*)
{
    return message<FactoryReset, Nothing>({.name = "factory-reset",
                                           .opcode = 0x0D,
                                           .access = Access::flash,
                                           .moves = true,
                                           .broadcast = true,
                                           .manual = "13",
                                           .errata = "N02 N24",
                                           .says = "Restore every factory setting."},
                                          side<FactoryReset>(control, 6), no_side);
}

struct RequestPing {
};
consteval auto row_of(const RequestPing*)
{
    return message<RequestPing, ReplyPing>({.name = "request-ping",
                                            .opcode = 0xA0,
                                            .reply_opcode = 0xD0,
                                            .manual = "14",
                                            .errata = "N12",
                                            .says = "Ask a device whether it is there."},
                                           side<RequestPing>(feedback, 6), row<ReplyPing>.reply);
}

struct RequestPositionFeedback {
};
consteval auto row_of(const RequestPositionFeedback*)
{
    return message<RequestPositionFeedback, ReplyPositionFeedback>(
        {.name = "request-position-feedback",
         .opcode = 0xA1,
         .reply_opcode = 0xD1,
         .manual = "14",
         .errata = "N12",
         .says = "Ask for position, speed and current; the direction is that of the position."},
        side<RequestPositionFeedback>(feedback, 6), row<ReplyPositionFeedback>.reply);
}

struct RequestSpeedFeedback {
};
consteval auto row_of(const RequestSpeedFeedback*)
{
    return message<RequestSpeedFeedback, ReplySpeedFeedback>(
        {.name = "request-speed-feedback",
         .opcode = 0xA2,
         .reply_opcode = 0xD2,
         .manual = "14",
         .errata = "N12",
         .says = "Ask for speed, position and current; the direction is that of the speed."},
        side<RequestSpeedFeedback>(feedback, 6), row<ReplySpeedFeedback>.reply);
}

struct RequestPositionControllerFeedback {
};
consteval auto row_of(const RequestPositionControllerFeedback*)
{
    return message<RequestPositionControllerFeedback, ReplyPositionControllerFeedback>(
        {.name = "request-position-controller-feedback",
         .opcode = 0xA3,
         .reply_opcode = 0xD3,
         .manual = "14",
         .errata = "N12",
         .says = "Ask for the settings of the position controller."},
        side<RequestPositionControllerFeedback>(feedback, 6), row<ReplyPositionControllerFeedback>.reply);
}

struct RequestSpeedControllerFeedback {
};
consteval auto row_of(const RequestSpeedControllerFeedback*)
{
    return message<RequestSpeedControllerFeedback, ReplySpeedControllerFeedback>(
        {.name = "request-speed-controller-feedback",
         .opcode = 0xA4,
         .reply_opcode = 0xD4,
         .manual = "14",
         .errata = "N12",
         .says = "Ask for the settings of the speed controller."},
        side<RequestSpeedControllerFeedback>(feedback, 6), row<ReplySpeedControllerFeedback>.reply);
}

struct RequestResponseTimeFeedback {
};
consteval auto row_of(const RequestResponseTimeFeedback*)
{
    return message<RequestResponseTimeFeedback, ReplyResponseTimeFeedback>(
        {.name = "request-response-time-feedback",
         .opcode = 0xA5,
         .reply_opcode = 0xD5,
         .manual = "14",
         .errata = "N12",
         .says = "Ask for the response time."},
        side<RequestResponseTimeFeedback>(feedback, 6), row<ReplyResponseTimeFeedback>.reply);
}

struct RequestGearRatioFeedback {
};
consteval auto row_of(const RequestGearRatioFeedback*)
{
    return message<RequestGearRatioFeedback, ReplyGearRatioFeedback>(
        {.name = "request-gear-ratio-feedback",
         .opcode = 0xA6,
         .reply_opcode = 0xD6,
         .manual = "14",
         .errata = "N12",
         .says = "Ask for the ratio of the external gear."},
        side<RequestGearRatioFeedback>(feedback, 6), row<ReplyGearRatioFeedback>.reply);
}

struct RequestControlOnOffFeedback {
};
consteval auto row_of(const RequestControlOnOffFeedback*)
{
    return message<RequestControlOnOffFeedback, ReplyControlOnOffFeedback>(
        {.name = "request-control-on-off-feedback",
         .opcode = 0xA7,
         .reply_opcode = 0xD7,
         .manual = "14",
         .errata = "N12",
         .says = "Ask whether the control is on."},
        side<RequestControlOnOffFeedback>(feedback, 6), row<ReplyControlOnOffFeedback>.reply);
}

struct RequestPositionModeFeedback {
};
consteval auto row_of(const RequestPositionModeFeedback*)
{
    return message<RequestPositionModeFeedback, ReplyPositionModeFeedback>(
        {.name = "request-position-mode-feedback",
         .opcode = 0xA8,
         .reply_opcode = 0xD8,
         .manual = "14",
         .errata = "N12",
         .says = "Ask whether positions are absolute or relative."},
        side<RequestPositionModeFeedback>(feedback, 6), row<ReplyPositionModeFeedback>.reply);
}

struct RequestFirmwareVersionFeedback {
};
consteval auto row_of(const RequestFirmwareVersionFeedback*)
{
    return message<RequestFirmwareVersionFeedback, ReplyFirmwareVersionFeedback>(
        {.name = "request-firmware-version-feedback",
         .opcode = 0xCD,
         .reply_opcode = 0xFD,
         .manual = "14",
         .errata = "N12",
         .says = "Ask for the firmware version."},
        side<RequestFirmwareVersionFeedback>(feedback, 6), row<ReplyFirmwareVersionFeedback>.reply);
}

struct SetControlDirection {
    std::uint8_t control_direction{};
};
consteval auto row_of(const SetControlDirection*)
{
    return message<SetControlDirection, Nothing>(
        {.name = "set-control-direction",
         .opcode = 0x0F,
         .access = Access::flash,
         .moves = true,
         .manual = "appendix ('14.')",
         .errata = "N08 N29",
         .says = "Invert the direction of control; the appendix gives it for a device that cannot be controlled."},
        side<SetControlDirection>(
            control, 7,
            u8(&SetControlDirection::control_direction, {.name = "control_direction", .byte = 6, .range = {0, 1}})),
        no_side);
}

/// Every message of the manual.
using ManualMessages = MessageList<
    PositionSpeedControl, AccelPositionControl, AccelSpeedControl, SetPositionController, SetSpeedController, SetId,
    SetBaudRate, SetResponseTime, SetExternalGearRatio, SetControlOnOff, SetPositionControlMode, ResetPosition,
    FactoryReset, RequestPing, RequestPositionFeedback, RequestSpeedFeedback, RequestPositionControllerFeedback,
    RequestSpeedControllerFeedback, RequestResponseTimeFeedback, RequestGearRatioFeedback, RequestControlOnOffFeedback,
    RequestPositionModeFeedback, RequestFirmwareVersionFeedback, ReplyPing, ReplyPositionFeedback, ReplySpeedFeedback,
    ReplyPositionControllerFeedback, ReplySpeedControllerFeedback, ReplyResponseTimeFeedback, ReplyGearRatioFeedback,
    ReplyControlOnOffFeedback, ReplyPositionModeFeedback, ReplyFirmwareVersionFeedback, SetControlDirection>;
inline constexpr auto manual_messages = catalogue(ManualMessages{});

} // namespace sinew::nuri
