#pragma once
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/wire/codec.hpp"

/// One message of each family written out by hand, with the checks and the results of the codec: what the rows have to
/// keep up with.
namespace sinew::bench::reference {

using EncodedFrame = std::expected<wire::Frame, Error>;

EncodedFrame encode_sam(int id, const sam::PositionControl& message);
EncodedFrame encode_nuri(int id, const nuri::PositionSpeedControl& message);
EncodedFrame encode_rmd(int id, const rmd::MultiLoopAngleSpeed& message);

std::expected<wire::Addressed<sam::PositionControl>, Error> decode_sam(const wire::Frame& frame);
std::expected<wire::Addressed<nuri::ReplyPositionFeedback>, Error> decode_nuri(const wire::Frame& frame);
std::expected<wire::Addressed<rmd::MotorState>, Error> decode_rmd(const wire::Frame& frame);

} // namespace sinew::bench::reference
