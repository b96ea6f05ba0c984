#pragma once
#include "sinew/wire/protocol.hpp"

namespace sinew::rmd {

/// RMD on the wire: one CAN frame with eight data bytes a message, told by identifier and first byte. The identifier of
/// a reply is the one of its request unless the firmware line says otherwise, so an acknowledgement can be byte for
/// byte its own request (R24): a link must never read back its own frames.
const wire::Protocol& protocol();

} // namespace sinew::rmd
