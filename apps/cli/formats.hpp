#pragma once
#include "sinew/family/families.hpp"

#include <string>

/// The rows in the words of other programs.
namespace sinew::cli {

/// A dissector of all families for Wireshark and tshark: CAN frames, and serial lines as link type USER0.
std::string lua_dissector();

/// A DBC file of a family on CAN. Where requests and replies share an identifier the signals are those of the replies,
/// and of requests that are answered with nothing.
std::string dbc_file(const Family& family, const wire::Profile& line);

} // namespace sinew::cli
