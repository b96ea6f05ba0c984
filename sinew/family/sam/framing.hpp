#pragma once
#include "sinew/wire/protocol.hpp"

namespace sinew::sam {

/// SAM on the wire. Requests start with 0xFF and end with a 7-bit checksum; 4, 6, 7 or 8 bytes, motion programs longer
/// (A.1 of the manual; S67). No request byte after the header is 0xFF but the fifth data byte of 199 and 202, which
/// hosts built on the code listing send unmasked (S41). Replies are 2 or 3 bare bytes: they can be counted, not told.
const wire::Protocol& protocol();

} // namespace sinew::sam
