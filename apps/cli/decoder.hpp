#pragma once
#include "apps/cli/capture.hpp"
#include "apps/cli/device.hpp"
#include "apps/cli/present.hpp"

/// Bytes that were seen somewhere, told what they are.
namespace sinew::cli {

/// One way to read a frame.
struct Reading {
    wire::Direction direction{};
    const wire::MessageInfo* message = nullptr;
    int id = -1;
    std::vector<Shown> values;
};

/// A frame, or bytes that are none: then `error` says why.
struct Decoded {
    const Family* family = nullptr;
    wire::Frame frame{}; ///< where it fits; `bytes` always has all
    std::vector<std::uint8_t> bytes;
    std::vector<Reading> readings; ///< more than one where request and answer look alike
    std::optional<Error> error;
};

/// How frames are to be read.
struct DecodeOptions {
    const Family* family = nullptr; ///< nullptr: guess
    std::string profile;            ///< empty: the default line
    std::string model;              ///< for scales
    std::string reply_to;           ///< the bytes answer this message
    std::optional<wire::Direction> only;
};

/// The family that bytes look like: FF FE is Nuri, FF is SAM, a CAN frame is RMD; nullptr: none of them.
const Family* guess_family(const Captured& captured);

/// All frames in what was captured, in order. Fails only where the options cannot be right.
std::expected<std::vector<Decoded>, Error> decode(const Captured& captured, const DecodeOptions& options);

// ---- for who listens to a conversation and knows more than the bytes ----

/// What frames of a family are read with: a device that nobody has named an id for.
std::expected<Device, Error> reader(const Family& family, const DecodeOptions& options);
/// One frame in the ways that it can be read; `only` where its direction is known.
Decoded decode_frame(const Device& device, const wire::Frame& frame, std::optional<wire::Direction> only);
/// A frame that answers `message`.
Decoded decode_reply(const Device& device, const wire::MessageInfo& message, const wire::Frame& frame);
/// Bytes that are no frame, and why.
Decoded no_frame(const Device& device, std::span<const std::uint8_t> bytes);
/// The bytes as a frame, cut to what fits.
wire::Frame to_frame(std::span<const std::uint8_t> bytes);

} // namespace sinew::cli
