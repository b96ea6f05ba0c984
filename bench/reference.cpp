#include "bench/reference.hpp"

namespace sinew::bench::reference {
namespace {

using wire::Frame;

[[gnu::cold]] Error out_of_range(std::string_view message, std::string_view field, std::int64_t value, std::int64_t low,
                                 std::int64_t high)
{
    return {.code = Errc::out_of_range, .message = message, .field = field, .value = value, .low = low, .high = high};
}

[[gnu::cold]] Error refused(Errc code, std::string_view message, const Frame& frame)
{
    Error error{.code = code, .message = message};
    keep_seen(error, frame.bytes());
    return error;
}

} // namespace

EncodedFrame encode_sam(int id, const sam::PositionControl& message)
{
    if (id < 0 || id > 254) [[unlikely]]
        return std::unexpected(out_of_range("position-control", "id", id, 0, 254));
    if (message.target_position > 32639) [[unlikely]]
        return std::unexpected(out_of_range("position-control", "target_position", message.target_position, 0, 32639));
    EncodedFrame out{std::in_place};
    auto& data = out->data;
    out->size = 7;
    data[0] = 0xFF;
    data[1] = 0xE0;
    data[2] = 0xC8;
    data[3] = static_cast<std::uint8_t>(id);
    data[4] = static_cast<std::uint8_t>(message.target_position >> 7);
    data[5] = message.target_position & 0x7F;
    data[6] = (data[1] ^ data[2] ^ data[3] ^ data[4] ^ data[5]) & 0x7F;
    return out;
}

EncodedFrame encode_nuri(int id, const nuri::PositionSpeedControl& message)
{
    constexpr std::string_view name = "position-speed-control";
    if (id < 0 || id > 255) [[unlikely]]
        return std::unexpected(out_of_range(name, "id", id, 0, 255));
    const auto direction = static_cast<std::uint8_t>(message.position_direction);
    if (direction > 1) [[unlikely]]
        return std::unexpected(out_of_range(name, "position_direction", direction, 0, 1));
    if (message.position > 65533) [[unlikely]]
        return std::unexpected(out_of_range(name, "position", message.position, 0, 65533));
    if (message.speed < 1 || message.speed > 65533) [[unlikely]]
        return std::unexpected(out_of_range(name, "speed", message.speed, 1, 65533));
    EncodedFrame out{std::in_place};
    auto& data = out->data;
    out->size = 11;
    data[0] = 0xFF;
    data[1] = 0xFE;
    data[2] = static_cast<std::uint8_t>(id);
    data[3] = 7;
    data[5] = 0x01;
    data[6] = direction;
    data[7] = static_cast<std::uint8_t>(message.position >> 8);
    data[8] = static_cast<std::uint8_t>(message.position);
    data[9] = static_cast<std::uint8_t>(message.speed >> 8);
    data[10] = static_cast<std::uint8_t>(message.speed);
    unsigned sum = data[2] + data[3];
    for (std::size_t i = 5; i < 11; ++i)
        sum += data[i];
    data[4] = static_cast<std::uint8_t>(~sum);
    return out;
}

EncodedFrame encode_rmd(int id, const rmd::MultiLoopAngleSpeed& message)
{
    if (id < 1 || id > 32) [[unlikely]]
        return std::unexpected(out_of_range("multi-loop-angle-speed", "id", id, 1, 32));
    EncodedFrame out{std::in_place};
    auto& data = out->data;
    out->can_id = 0x140 + static_cast<std::uint32_t>(id);
    out->size = 8;
    const auto angle = static_cast<std::uint32_t>(message.angle);
    data[0] = 0xA4;
    data[2] = static_cast<std::uint8_t>(message.max_speed);
    data[3] = static_cast<std::uint8_t>(message.max_speed >> 8);
    data[4] = static_cast<std::uint8_t>(angle);
    data[5] = static_cast<std::uint8_t>(angle >> 8);
    data[6] = static_cast<std::uint8_t>(angle >> 16);
    data[7] = static_cast<std::uint8_t>(angle >> 24);
    return out;
}

std::expected<wire::Addressed<sam::PositionControl>, Error> decode_sam(const Frame& frame)
{
    constexpr std::string_view name = "position-control";
    const auto& data = frame.data;
    if (frame.size != 7) [[unlikely]]
        return std::unexpected(refused(Errc::bad_length, name, frame));
    if (data[0] != 0xFF || data[1] != 0xE0 || data[2] != 0xC8) [[unlikely]]
        return std::unexpected(refused(Errc::bad_constant, name, frame));
    if (data[6] != ((data[1] ^ data[2] ^ data[3] ^ data[4] ^ data[5]) & 0x7F)) [[unlikely]]
        return std::unexpected(refused(Errc::bad_checksum, name, frame));
    if (data[3] > 254) [[unlikely]]
        return std::unexpected(refused(Errc::bad_id, name, frame));
    if (data[5] > 0x7F) [[unlikely]]
        return std::unexpected(refused(Errc::bad_constant, name, frame));
    const int position = data[4] << 7 | data[5];
    if (position > 32639) [[unlikely]]
        return std::unexpected(out_of_range(name, "target_position", position, 0, 32639));
    std::expected<wire::Addressed<sam::PositionControl>, Error> out{std::in_place};
    out->id = data[3];
    out->message.target_position = static_cast<std::uint16_t>(position);
    return out;
}

std::expected<wire::Addressed<nuri::ReplyPositionFeedback>, Error> decode_nuri(const Frame& frame)
{
    constexpr std::string_view name = "request-position-feedback";
    const auto& data = frame.data;
    if (frame.size != 12) [[unlikely]]
        return std::unexpected(refused(Errc::bad_length, name, frame));
    if (data[0] != 0xFF || data[1] != 0xFE || data[3] != 8 || data[5] != 0xD1) [[unlikely]]
        return std::unexpected(refused(Errc::bad_constant, name, frame));
    unsigned sum = data[2] + data[3];
    for (std::size_t i = 5; i < 12; ++i)
        sum += data[i];
    if (data[4] != static_cast<std::uint8_t>(~sum)) [[unlikely]]
        return std::unexpected(refused(Errc::bad_checksum, name, frame));
    if (data[2] > 254) [[unlikely]]
        return std::unexpected(refused(Errc::bad_id, name, frame));
    const int position = data[7] << 8 | data[8];
    const int speed = data[9] << 8 | data[10];
    if (data[6] > 1) [[unlikely]]
        return std::unexpected(out_of_range(name, "position_direction", data[6], 0, 1));
    if (position > 65533) [[unlikely]]
        return std::unexpected(out_of_range(name, "position", position, 0, 65533));
    if (speed > 65533) [[unlikely]]
        return std::unexpected(out_of_range(name, "speed", speed, 0, 65533));
    if (data[11] > 254) [[unlikely]]
        return std::unexpected(out_of_range(name, "current", data[11], 0, 254));
    std::expected<wire::Addressed<nuri::ReplyPositionFeedback>, Error> out{std::in_place};
    out->id = data[2];
    out->message.position_direction = static_cast<nuri::Rotation>(data[6]);
    out->message.position = static_cast<std::uint16_t>(position);
    out->message.speed = static_cast<std::uint16_t>(speed);
    out->message.current = data[11];
    return out;
}

std::expected<wire::Addressed<rmd::MotorState>, Error> decode_rmd(const Frame& frame)
{
    constexpr std::string_view name = "read-status2";
    const auto& data = frame.data;
    if (frame.size != 8) [[unlikely]]
        return std::unexpected(refused(Errc::bad_length, name, frame));
    if (data[0] != 0x9C) [[unlikely]]
        return std::unexpected(refused(Errc::bad_constant, name, frame));
    const int id = static_cast<int>(frame.can_id) - 0x140;
    if (id < 1 || id > 32) [[unlikely]]
        return std::unexpected(refused(Errc::bad_id, name, frame));
    const auto iq = static_cast<std::int16_t>(data[2] | data[3] << 8);
    if (iq < -2048 || iq > 2048) [[unlikely]]
        return std::unexpected(out_of_range(name, "iq", iq, -2048, 2048));
    std::expected<wire::Addressed<rmd::MotorState>, Error> out{std::in_place};
    out->id = id;
    out->message.temperature = static_cast<std::int8_t>(data[1]);
    out->message.iq = iq;
    out->message.speed = static_cast<std::int16_t>(data[4] | data[5] << 8);
    out->message.encoder = static_cast<std::uint16_t>(data[6] | data[7] << 8);
    return out;
}

} // namespace sinew::bench::reference
