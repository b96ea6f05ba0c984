#pragma once
#include "apps/cli/json.hpp"
#include "apps/cli/session.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/link/report.hpp"

#include <map>
#include <optional>
#include <string>

/// What links tell of themselves, as `bus`, `doctor` and `watch` show it.
namespace sinew::cli {

/// Of the link of a bus, which `uri` names. An SLCAN adapter is asked for its flags first, which takes up to 0.1 s.
link::Report report_of(bus::Bus& bus, std::string_view uri);

Json report_json(const link::Report& report);

/// What is not as it should be: the state of a CAN controller where it is not error-active, its errors, and whatever
/// was counted. Empty: nothing.
std::string troubles_of(const link::Report& report);

/// Of all buses that are open, asked again no more often than a person reads.
class LinkReports
{
public:
    void look(Session& session);
    /// nullptr: a link that counts nothing, as all that are not CAN, or one that is lost.
    const link::Report* of(const bus::Bus& bus) const;

private:
    std::optional<TimePoint> looked_;
    std::map<const bus::Bus*, link::Report> all_;
};

} // namespace sinew::cli
