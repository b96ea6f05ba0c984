#pragma once
#include "sinew/family/nuri/messages.hpp"

/// Nuri: the messages of the MC line. From mode 9 on the same numbers mean other things than in the document: 0x0C is
/// its position reset and 0x0D its factory reset, here they are control on/off and position mode. Sources in README.md.
/// Names are those of the document where it is the same thing.
namespace sinew::nuri::mc {

inline constexpr std::string_view source = "MC-RS485";

// ---- replies ----

struct ReplyRatedSpeedFeedback {
    std::uint16_t rated_speed{};
};
consteval auto row_of(const ReplyRatedSpeedFeedback*)
{
    return message<Nothing, ReplyRatedSpeedFeedback>(
        {.name = "reply-rated-speed-feedback", .opcode = 0xD6, .manual = source, .says = "Rated speed of the motor."},
        no_side,
        side<ReplyRatedSpeedFeedback>(
            feedback, 8,
            u16_be(&ReplyRatedSpeedFeedback::rated_speed,
                   {.name = "rated_speed", .byte = 6, .says = "unit not confirmed; drivers take it for RPM"})));
}

struct ReplyResolutionFeedback {
    std::uint16_t resolution{};
};
consteval auto row_of(const ReplyResolutionFeedback*)
{
    return message<Nothing, ReplyResolutionFeedback>(
        {.name = "reply-resolution-feedback", .opcode = 0xD7, .manual = source, .says = "Resolution of the encoder."},
        no_side,
        side<ReplyResolutionFeedback>(feedback, 8,
                                      u16_be(&ReplyResolutionFeedback::resolution, {.name = "resolution", .byte = 6})));
}

struct ReplyGearRatioFeedback {
    std::uint16_t gear_ratio{};
};
consteval auto row_of(const ReplyGearRatioFeedback*)
{
    return message<Nothing, ReplyGearRatioFeedback>(
        {.name = "reply-gear-ratio-feedback", .opcode = 0xD8, .manual = source, .says = "Ratio of the gear."}, no_side,
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
        {.name = "reply-control-on-off-feedback",
         .opcode = 0xD9,
         .manual = source,
         .says = "Whether the control is on."},
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
         .opcode = 0xDA,
         .manual = source,
         .says = "Whether positions are absolute or relative."},
        no_side,
        side<ReplyPositionModeFeedback>(
            feedback, 7,
            u8(&ReplyPositionModeFeedback::position_mode,
               {.name = "position_mode", .byte = 6, .range = {0, 1}, .labels = position_modes})));
}

struct ReplyControlDirectionFeedback {
    Rotation control_direction{};
};
consteval auto row_of(const ReplyControlDirectionFeedback*)
{
    return message<Nothing, ReplyControlDirectionFeedback>(
        {.name = "reply-control-direction-feedback",
         .opcode = 0xDB,
         .manual = source,
         .says = "The direction of control."},
        no_side,
        side<ReplyControlDirectionFeedback>(
            feedback, 7,
            u8(&ReplyControlDirectionFeedback::control_direction,
               {.name = "control_direction", .byte = 6, .range = {0, 1}, .labels = rotations})));
}

// ---- settings ----

struct SetRatedSpeed {
    std::uint16_t rated_speed{};
};
consteval auto row_of(const SetRatedSpeed*)
{
    return message<SetRatedSpeed, Nothing>(
        {.name = "set-rated-speed",
         .opcode = 0x09,
         .access = Access::flash,
         .broadcast = true,
         .manual = source,
         .says = "Store the rated speed of the motor."},
        side<SetRatedSpeed>(
            control, 8,
            u16_be(&SetRatedSpeed::rated_speed,
                   {.name = "rated_speed", .byte = 6, .says = "unit not confirmed; drivers take it for RPM"})),
        no_side);
}

struct SetResolution {
    std::uint16_t resolution{};
};
consteval auto row_of(const SetResolution*)
{
    return message<SetResolution, Nothing>(
        {.name = "set-resolution",
         .opcode = 0x0A,
         .access = Access::flash,
         .broadcast = true,
         .manual = source,
         .says = "Store the resolution of the encoder."},
        side<SetResolution>(control, 8, u16_be(&SetResolution::resolution, {.name = "resolution", .byte = 6})),
        no_side);
}

struct SetExternalGearRatio {
    std::uint16_t gear_ratio{};
};
consteval auto row_of(const SetExternalGearRatio*)
{
    return message<SetExternalGearRatio, Nothing>(
        {.name = "set-external-gear-ratio",
         .opcode = 0x0B,
         .access = Access::flash,
         .broadcast = true,
         .manual = source,
         .says = "Store the ratio of the gear."},
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
         .opcode = 0x0C,
         .access = Access::flash,
         .moves = true,
         .broadcast = true,
         .manual = source,
         .errata = "N22",
         .says = "Switch the control on or off; 0 is on."},
        side<SetControlOnOff>(
            nuri::control, 7,
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
         .opcode = 0x0D,
         .access = Access::flash,
         .broadcast = true,
         .manual = source,
         .says = "Store whether positions are absolute or relative."},
        side<SetPositionControlMode>(
            control, 7,
            u8(&SetPositionControlMode::position_mode,
               {.name = "position_mode", .byte = 6, .range = {0, 1}, .labels = position_modes})),
        no_side);
}

struct SetControlDirection {
    Rotation control_direction{};
};
consteval auto row_of(const SetControlDirection*)
{
    return message<SetControlDirection, Nothing>(
        {.name = "set-control-direction",
         .opcode = 0x0E,
         .access = Access::flash,
         .moves = true,
         .broadcast = true,
         .manual = source,
         .errata = "N08",
         .says = "Store the direction of control."},
        side<SetControlDirection>(control, 7,
                                  u8(&SetControlDirection::control_direction,
                                     {.name = "control_direction", .byte = 6, .range = {0, 1}, .labels = rotations})),
        no_side);
}

struct ResetPosition {
};
consteval auto row_of(const ResetPosition*)
{
    return message<ResetPosition, Nothing>({.name = "reset-position",
                                            .opcode = 0x0F,
                                            .access = Access::command,
                                            .moves = true,
                                            .broadcast = true,
                                            .manual = source,
                                            .says = "Make the present position zero."},
                                           side<ResetPosition>(control, 6), no_side);
}

struct FactoryReset {
};
consteval auto row_of(const FactoryReset*)
{
    return message<FactoryReset, Nothing>({.name = "factory-reset",
                                           .opcode = 0x10,
                                           .access = Access::flash,
                                           .moves = true,
                                           .broadcast = true,
                                           .manual = source,
                                           .says = "Restore every factory setting."},
                                          side<FactoryReset>(control, 6), no_side);
}

// ---- requests ----

struct RequestRatedSpeedFeedback {
};
consteval auto row_of(const RequestRatedSpeedFeedback*)
{
    return message<RequestRatedSpeedFeedback, ReplyRatedSpeedFeedback>({.name = "request-rated-speed-feedback",
                                                                        .opcode = 0xA6,
                                                                        .reply_opcode = 0xD6,
                                                                        .manual = source,
                                                                        .says = "Ask for the rated speed."},
                                                                       side<RequestRatedSpeedFeedback>(feedback, 6),
                                                                       row<ReplyRatedSpeedFeedback>.reply);
}

struct RequestResolutionFeedback {
};
consteval auto row_of(const RequestResolutionFeedback*)
{
    return message<RequestResolutionFeedback, ReplyResolutionFeedback>({.name = "request-resolution-feedback",
                                                                        .opcode = 0xA7,
                                                                        .reply_opcode = 0xD7,
                                                                        .manual = source,
                                                                        .says = "Ask for the resolution."},
                                                                       side<RequestResolutionFeedback>(feedback, 6),
                                                                       row<ReplyResolutionFeedback>.reply);
}

struct RequestGearRatioFeedback {
};
consteval auto row_of(const RequestGearRatioFeedback*)
{
    return message<RequestGearRatioFeedback, ReplyGearRatioFeedback>({.name = "request-gear-ratio-feedback",
                                                                      .opcode = 0xA8,
                                                                      .reply_opcode = 0xD8,
                                                                      .manual = source,
                                                                      .says = "Ask for the ratio of the gear."},
                                                                     side<RequestGearRatioFeedback>(feedback, 6),
                                                                     row<ReplyGearRatioFeedback>.reply);
}

struct RequestControlOnOffFeedback {
};
consteval auto row_of(const RequestControlOnOffFeedback*)
{
    return message<RequestControlOnOffFeedback, ReplyControlOnOffFeedback>(
        {.name = "request-control-on-off-feedback",
         .opcode = 0xA9,
         .reply_opcode = 0xD9,
         .manual = source,
         .says = "Ask whether the control is on."},
        side<RequestControlOnOffFeedback>(feedback, 6), row<ReplyControlOnOffFeedback>.reply);
}

struct RequestPositionModeFeedback {
};
consteval auto row_of(const RequestPositionModeFeedback*)
{
    return message<RequestPositionModeFeedback, ReplyPositionModeFeedback>(
        {.name = "request-position-mode-feedback",
         .opcode = 0xAA,
         .reply_opcode = 0xDA,
         .manual = source,
         .says = "Ask whether positions are absolute or relative."},
        side<RequestPositionModeFeedback>(feedback, 6), row<ReplyPositionModeFeedback>.reply);
}

struct RequestControlDirectionFeedback {
};
consteval auto row_of(const RequestControlDirectionFeedback*)
{
    return message<RequestControlDirectionFeedback, ReplyControlDirectionFeedback>(
        {.name = "request-control-direction-feedback",
         .opcode = 0xAB,
         .reply_opcode = 0xDB,
         .manual = source,
         .says = "Ask for the direction of control."},
        side<RequestControlDirectionFeedback>(feedback, 6), row<ReplyControlDirectionFeedback>.reply);
}

/// Modes 1 to 8 and the feedback 0xA0 to 0xA5 are those of the document. Mode 0x11 (open loop) has no known layout.
using Messages =
    MessageList<PositionSpeedControl, AccelPositionControl, AccelSpeedControl, SetPositionController,
                SetSpeedController, SetId, SetBaudRate, SetResponseTime, SetRatedSpeed, SetResolution,
                SetExternalGearRatio, SetControlOnOff, SetPositionControlMode, SetControlDirection, ResetPosition,
                FactoryReset, RequestPing, RequestPositionFeedback, RequestSpeedFeedback,
                RequestPositionControllerFeedback, RequestSpeedControllerFeedback, RequestResponseTimeFeedback,
                RequestRatedSpeedFeedback, RequestResolutionFeedback, RequestGearRatioFeedback,
                RequestControlOnOffFeedback, RequestPositionModeFeedback, RequestControlDirectionFeedback,
                RequestFirmwareVersionFeedback, ReplyPing, ReplyPositionFeedback, ReplySpeedFeedback,
                ReplyPositionControllerFeedback, ReplySpeedControllerFeedback, ReplyResponseTimeFeedback,
                ReplyRatedSpeedFeedback, ReplyResolutionFeedback, ReplyGearRatioFeedback, ReplyControlOnOffFeedback,
                ReplyPositionModeFeedback, ReplyControlDirectionFeedback, ReplyFirmwareVersionFeedback>;
inline constexpr auto messages = catalogue(Messages{});

} // namespace sinew::nuri::mc
