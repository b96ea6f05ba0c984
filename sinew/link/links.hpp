#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/uri.hpp"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::link {

/// One way to reach a wire: how it is written, and how it is opened.
struct Scheme {
    std::string_view name;                 ///< "serial"
    std::string_view form;                 ///< "serial:DEVICE?baud=RATE"
    std::string_view says;                 ///< one sentence for the help
    std::vector<std::string_view> options; ///< the options it knows; others are refused
    std::function<std::expected<AnyLink, Error>(const Uri&, Clock&)> open;
};

/// A set of schemes: a value that whoever opens a robot passes on. `system()` has the real ones; the simulator and
/// recordings add theirs.
class Links
{
public:
    /// serial, rs485, pty, tcp, slcan, can.
    static Links system();

    void add(Scheme scheme);
    /// Opens what `uri` names. The clock must outlive the link.
    std::expected<AnyLink, Error> open(std::string_view uri, Clock& clock) const;
    std::span<const Scheme> schemes() const { return schemes_; }

private:
    std::vector<Scheme> schemes_;
};

} // namespace sinew::link
