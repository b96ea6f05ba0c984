#pragma once
#include "sinew/link/adapter.hpp"
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/reopen.hpp"
#include "sinew/link/uri.hpp"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sinew::link {

/// One way to reach a wire: how it is written, and how it is opened.
struct Scheme {
    std::string_view name;                 ///< "serial"
    std::string_view form;                 ///< "serial:DEVICE?baud=RATE"
    std::string_view says;                 ///< one sentence for the help
    std::vector<std::string_view> options; ///< the options it knows; others are refused
    std::function<std::expected<AnyLink, Error>(const Uri&, Clock&)> open;
    /// Makes what opens a lost link again; empty: `open` does.
    std::function<Reopen(const Uri&, Clock&)> reopener{};
};

/// A set of schemes: a value that whoever opens a robot passes on. `system()` has the real ones; the simulator and
/// recordings add theirs.
class Links
{
public:
    /// serial, rs485, pty, tcp, slcan, can.
    static Links system(const Roots& roots = {});

    void add(Scheme scheme);
    /// Opens what `uri` names. The clock must outlive the link.
    std::expected<AnyLink, Error> open(std::string_view uri, Clock& clock) const;
    /// Opens what `uri` names again after the link was lost; to be made while it is open. The clock must outlive it.
    ///
    /// A serial port that comes back under another name is found again: where `uri` names a symlink, as those under
    /// /dev/serial/by-id are, it is followed anew; where it names the device file itself, the adapter with the same
    /// vendor, product and serial number is taken, and no other one that has got the name in the meantime. An adapter
    /// without a serial number is known by its device file only.
    Reopen reopener(std::string_view uri, Clock& clock) const;
    std::span<const Scheme> schemes() const { return schemes_; }

private:
    std::expected<std::pair<Uri, const Scheme*>, Error> find(std::string_view uri) const;

    std::vector<Scheme> schemes_;
};

} // namespace sinew::link
