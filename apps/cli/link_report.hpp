#pragma once
#include "apps/cli/json.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/link/report.hpp"

/// What links tell of themselves, as `bus` and `doctor` show it.
namespace sinew::cli {

/// Of the link of a bus, which `uri` names. An SLCAN adapter is asked for its flags first, which takes up to 0.1 s.
link::Report report_of(bus::Bus& bus, std::string_view uri);

Json report_json(const link::Report& report);

} // namespace sinew::cli
