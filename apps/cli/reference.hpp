#pragma once
#include "apps/cli/json.hpp"
#include "sinew/family/families.hpp"

namespace sinew::cli {

/// A message with all that its row says: name, opcode, access, both directions with every field.
Json to_json(const Family& family, const wire::Profile& line, const wire::MessageInfo& message);
/// The same to read.
std::string reference_text(const Family& family, const wire::Profile& line, const wire::MessageInfo& message);

} // namespace sinew::cli
