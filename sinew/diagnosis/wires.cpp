#include "sinew/base/bytes.hpp"
#include "sinew/diagnosis/probes.hpp"
#include "sinew/diagnosis/walk.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::diagnosis {
namespace {

/// Longer than the pause of a master that cycles ten times a second.
constexpr Duration listening = std::chrono::milliseconds{250};

} // namespace

Checked check_traffic(Walk& walk)
{
    walk.progress("listening");
    const auto heard = walk.line->listen(listening);
    if (!heard)
        return std::unexpected(heard.error());
    if (heard->empty()) {
        walk.fine("traffic", fmt::format("nobody talks unasked (heard nothing in {:.2f} s)", seconds(listening)));
        return {};
    }
    std::size_t count = 0;
    for (const auto& frame : *heard)
        count += walk.line->can() ? 1 : frame.size;
    const auto first = to_hex(heard->front().bytes());
    walk.add("foreign-traffic", walk.line->can() ? fmt::format("{} frames in {:.2f} s, the first {:X}#{}", count,
                                                               seconds(listening), heard->front().can_id, first)
                                                 : fmt::format("{} bytes in {:.2f} s, beginning with {}", count,
                                                               seconds(listening), first));
    return {};
}

/// Two questions to ids that nobody has as a rule: when both come back as they went out, it was the adapter.
Checked check_echo(Walk& walk)
{
    if (walk.line->can())
        return {};
    const auto& family = walk.family != nullptr ? *walk.family : *find_family("sam");
    int asked = 0, came_back = 0;
    std::string seen;
    for (auto id = family.ids.high; id > family.ids.low && asked < 2; --id) {
        const auto request = walk.line->safe_one(ways_to_ask(family, static_cast<int>(id)));
        if (!request)
            continue;
        const auto look = walk.line->look(*request, family, Walk::quick(family));
        if (!look)
            return std::unexpected(look.error());
        ++asked;
        const auto sent = request->frame.bytes();
        if (look->heard.size() >= sent.size() && std::ranges::equal(sent, std::span(look->heard).first(sent.size()))) {
            ++came_back;
            seen = to_hex(sent);
        }
    }
    if (asked > 0 && came_back == asked) {
        walk.add("echo", fmt::format("{} was sent and came back", seen));
        walk.line->swallow_echo();
    } else {
        const bool swallowed = walk.uri && walk.uri->option("echo") == "on";
        walk.fine("echo", swallowed ? "echo=on: what comes back is swallowed" : "what is sent does not come back");
    }
    return {};
}

} // namespace sinew::diagnosis
