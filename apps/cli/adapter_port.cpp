#include "apps/cli/adapter_port.hpp"

#include "sinew/link/slcan_codec.hpp"
#include "sinew/link/uri.hpp"

#include <algorithm>
#include <vector>

namespace sinew::cli {
namespace {

/// "z" and CR, for each frame that the adapter takes.
constexpr std::size_t acknowledgement = 2;

struct Both {
    Duration out{}, back{};
};

Both time_of(const AdapterPort& port, std::span<const wire::Request> requests)
{
    std::size_t out = 0, back = 0;
    for (const auto& request : requests) {
        out += link::slcan::frame_text_size(request.frame.size);
        back += acknowledgement;
        if (const int replies = bus::reply_count(request); replies > 0)
            back += static_cast<std::size_t>(replies) * link::slcan::frame_text_size(request.message->reply.size);
    }
    if (port.baud == 0)
        return {};
    return {bit_time(bus::frame_bits(false, out), port.baud), bit_time(bus::frame_bits(false, back), port.baud)};
}

/// Of each identifier the request that is longest with its answers; all that nobody answers.
std::vector<wire::Request> outstanding(std::span<const wire::Request> running)
{
    const auto size = [](const wire::Request& one) {
        return one.frame.size + static_cast<std::size_t>(bus::reply_count(one)) * one.message->reply.size;
    };
    std::vector<wire::Request> out;
    for (const auto& request : running) {
        const auto same = std::ranges::find_if(out, [&](const wire::Request& known) {
            return known.frame.can_id == request.frame.can_id && bus::reply_count(known) > 0;
        });
        if (same == out.end() || bus::reply_count(request) == 0)
            out.push_back(request);
        else if (size(request) > size(*same))
            *same = request;
    }
    return out;
}

} // namespace

AdapterPort adapter_port_of(const std::string& link)
{
    const auto uri = link::parse_uri(link);
    if (!uri || uri->scheme != "slcan")
        return {};
    const auto baud = uri->number("baud");
    return {.is_slcan = true, .baud = baud ? baud->value_or(0) : 0};
}

Duration time_on_port(const AdapterPort& port, std::span<const wire::Request> requests)
{
    const auto time = time_of(port, requests);
    return std::max(time.out, time.back);
}

bus::StopBound on_port(const AdapterPort& port, bus::StopBound bound, std::span<const wire::Request> running,
                       std::span<const wire::Request> stop)
{
    const auto before = time_of(port, outstanding(running));
    const auto own = time_of(port, stop);
    const auto first = time_of(port, stop.first(std::min<std::size_t>(1, stop.size())));
    bound.begins += before.out + before.back + first.out;
    bound.first += before.out + before.back + first.out;
    bound.ends += before.out + before.back + own.out + own.back;
    return bound;
}

} // namespace sinew::cli
