#pragma once
#include "apps/cli/bus_target.hpp"
#include "sinew/record/file.hpp"

namespace sinew::cli {

/// Somewhere frames come from. None of them sends anything.
class Source
{
public:
    virtual ~Source() = default;
    /// What has come by `until`, or earlier if something has; nothing when nothing came. `over` afterwards: it is over.
    virtual std::expected<std::optional<record::Captured>, Error> next(Duration patience) = 0;
    bool over = false;
};

/// A recording of any format.
std::expected<std::unique_ptr<Source>, Error> open_recording(const std::string& path);
/// A link that is only listened to, or a bus of a simulator that runs elsewhere on this machine (`sim:FILE#BUS`).
std::expected<std::unique_ptr<Source>, Error> open_live(const BusTarget& target);

} // namespace sinew::cli
