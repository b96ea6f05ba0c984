#pragma once
#include "sinew/link/links.hpp"
#include "sinew/record/captured.hpp"

#include <map>
#include <memory>
#include <string>

namespace sinew::record {

/// Recordings as links, `replay:FILE#BUS`: a bus whose devices answer a request as they did in the recording, in the
/// order of the recording and after the same time. For tests and bug reports. A request that was never recorded, or
/// whose answers are used up, meets silence, as if the device were gone; with `loop=on` they begin again. What was
/// asked only once, such as a setting, is answered so again and again.
///
/// Any format of `FileReader` will do if it says who sent what; on CAN the order tells where it does not. All buses of
/// a file share one virtual time, which begins with its first frame and moves in waits alone. Owns files and clocks, so
/// it must outlive all links that were opened through it. Single-threaded.
class Replays
{
public:
    Replays();
    ~Replays();
    Replays(const Replays&) = delete;
    Replays& operator=(const Replays&) = delete;

    /// Opens a bus; one bus: `#BUS` may be left out. The clock must be that of the file. `bad_file` where it is no
    /// recording, `link_not_found` where it has no such bus.
    std::expected<link::AnyLink, Error> open(const link::Uri& uri, link::Clock& clock);
    /// The clock that a link of this kind needs.
    std::expected<link::Clock*, Error> clock_for(std::string_view uri);
    /// As `Answers::given`, of all buses.
    std::uint64_t given() const;

private:
    class File;
    std::expected<File*, Error> file(const std::string& path);

    std::map<std::string, std::unique_ptr<File>> files_;
};

/// Whether a link is one of these.
bool is_replay(std::string_view uri);

/// Adds the scheme. The recordings must outlive the links.
void add(link::Links& links, Replays& replays);

} // namespace sinew::record
