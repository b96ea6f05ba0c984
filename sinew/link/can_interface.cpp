#include "sinew/link/can_interface.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/link/descriptor.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/can/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/socket.h>

namespace sinew::link {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// A value of the kernel in its own layout; zeros where the attribute is shorter (an older kernel).
template <class T>
T value_of(Bytes bytes)
{
    T value{};
    if (!bytes.empty()) // an empty span may point nowhere
        std::memcpy(&value, bytes.data(), std::min(bytes.size(), sizeof value));
    return value;
}

std::string text_of(Bytes bytes)
{
    const auto end = std::ranges::find(bytes, std::uint8_t{0});
    return {bytes.begin(), end};
}

/// Calls `take(type, payload)` for each attribute; an attribute that is cut short ends it.
template <class Take>
void for_each_attribute(Bytes bytes, Take&& take)
{
    while (bytes.size() >= sizeof(rtattr)) {
        const auto header = value_of<rtattr>(bytes);
        if (header.rta_len < RTA_LENGTH(0) || header.rta_len > bytes.size())
            return;
        take(header.rta_type & NLA_TYPE_MASK, bytes.first(header.rta_len).subspan(RTA_LENGTH(0)));
        bytes = bytes.subspan(std::min<std::size_t>(RTA_ALIGN(header.rta_len), bytes.size()));
    }
}

CanState state_of(std::uint32_t kernels)
{
    switch (kernels) {
    case CAN_STATE_ERROR_ACTIVE:
        return CanState::error_active;
    case CAN_STATE_ERROR_WARNING:
        return CanState::error_warning;
    case CAN_STATE_ERROR_PASSIVE:
        return CanState::error_passive;
    case CAN_STATE_BUS_OFF:
        return CanState::bus_off;
    case CAN_STATE_STOPPED:
        return CanState::stopped;
    case CAN_STATE_SLEEPING:
        return CanState::sleeping;
    default:
        return CanState::unknown;
    }
}

void read_controller(Bytes data, CanInterface& into)
{
    for_each_attribute(data, [&](int type, Bytes payload) {
        if (type == IFLA_CAN_BITTIMING)
            into.bit_rate = value_of<can_bittiming>(payload).bitrate;
        else if (type == IFLA_CAN_STATE)
            into.state = state_of(value_of<std::uint32_t>(payload));
        else if (type == IFLA_CAN_RESTART_MS)
            into.restart_ms = value_of<std::uint32_t>(payload);
        else if (type == IFLA_CAN_BERR_COUNTER) {
            const auto errors = value_of<can_berr_counter>(payload);
            into.tx_errors = errors.txerr;
            into.rx_errors = errors.rxerr;
        }
    });
}

void read_kind(Bytes link_info, CanInterface& into)
{
    for_each_attribute(link_info, [&](int type, Bytes payload) {
        if (type == IFLA_INFO_KIND)
            into.kind = text_of(payload);
    });
    // vcan and vxcan carry no data of this layout.
    if (into.kind == "vcan" || into.kind == "vxcan")
        return;
    for_each_attribute(link_info, [&](int type, Bytes payload) {
        if (type == IFLA_INFO_DATA)
            read_controller(payload, into);
        else if (type == IFLA_INFO_XSTATS) {
            const auto statistics = value_of<can_device_stats>(payload);
            into.bus_offs = statistics.bus_off;
            into.restarts = statistics.restarts;
        }
    });
}

std::unexpected<Error> no_answer()
{
    return fail(Errc::link_failed,
                fmt::format("cannot ask the kernel for its CAN interfaces: {}", std::strerror(errno)));
}

} // namespace

std::string_view to_word(CanState state)
{
    switch (state) {
    case CanState::error_active:
        return "error-active";
    case CanState::error_warning:
        return "error-warning";
    case CanState::error_passive:
        return "error-passive";
    case CanState::bus_off:
        return "bus-off";
    case CanState::stopped:
        return "stopped";
    case CanState::sleeping:
        return "sleeping";
    case CanState::unknown:
        break;
    }
    return "unknown";
}

std::optional<CanInterface> parse_can_interface(std::span<const std::uint8_t> message)
{
    constexpr std::size_t head = NLMSG_LENGTH(sizeof(ifinfomsg));
    const auto header = value_of<nlmsghdr>(message);
    if (message.size() < head || header.nlmsg_type != RTM_NEWLINK || header.nlmsg_len > message.size() ||
        header.nlmsg_len < head)
        return std::nullopt;
    const auto info = value_of<ifinfomsg>(message.subspan(NLMSG_HDRLEN));
    if (info.ifi_type != ARPHRD_CAN)
        return std::nullopt;
    CanInterface out{.index = info.ifi_index, .is_up = (info.ifi_flags & IFF_UP) != 0};
    for_each_attribute(message.first(header.nlmsg_len).subspan(head), [&](int type, Bytes payload) {
        if (type == IFLA_IFNAME)
            out.name = text_of(payload);
        else if (type == IFLA_TXQLEN)
            out.tx_queue = value_of<std::uint32_t>(payload);
        else if (type == IFLA_LINKINFO)
            read_kind(payload, out);
        else if (type == IFLA_STATS64) {
            const auto statistics = value_of<rtnl_link_stats64>(payload);
            out.rx_dropped = statistics.rx_dropped + statistics.rx_over_errors;
            out.tx_dropped = statistics.tx_dropped;
        }
    });
    if (out.kind == "vcan" || out.kind == "vxcan") // they have no queue whatever txqueuelen says
        out.tx_queue = 0;
    return out;
}

std::expected<std::vector<CanInterface>, Error> can_interfaces()
{
    const Fd fd{::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)};
    if (!fd)
        return no_answer();
    const timeval patience{.tv_sec = 1, .tv_usec = 0}; // the kernel answers at once
    ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    struct {
        nlmsghdr header;
        ifinfomsg info;
    } const request{
        .header = {.nlmsg_len = sizeof request, .nlmsg_type = RTM_GETLINK, .nlmsg_flags = NLM_F_REQUEST | NLM_F_DUMP},
        .info = {.ifi_family = AF_UNSPEC}};
    if (::send(fd.get(), &request, sizeof request, 0) < 0)
        return no_answer();

    std::vector<CanInterface> all;
    std::vector<std::uint8_t> answer(64 * 1024); // the kernel sends 32 KiB at most in one piece
    for (;;) {
        const ssize_t size = ::recv(fd.get(), answer.data(), answer.size(), 0);
        if (size < 0)
            return no_answer();
        for (Bytes rest = Bytes(answer).first(static_cast<std::size_t>(size)); rest.size() >= sizeof(nlmsghdr);) {
            const auto header = value_of<nlmsghdr>(rest);
            if (header.nlmsg_type == NLMSG_DONE)
                return all;
            if (header.nlmsg_type == NLMSG_ERROR || header.nlmsg_len < NLMSG_HDRLEN || header.nlmsg_len > rest.size())
                return fail(Errc::link_failed, "the kernel does not tell its network interfaces");
            if (auto one = parse_can_interface(rest))
                all.push_back(std::move(*one));
            rest = rest.subspan(std::min<std::size_t>(NLMSG_ALIGN(header.nlmsg_len), rest.size()));
        }
    }
}

std::expected<CanInterface, Error> can_interface(std::string_view name)
{
    auto all = can_interfaces();
    if (!all)
        return std::unexpected(std::move(all.error()));
    std::vector<std::string_view> names;
    for (CanInterface& one : *all) {
        if (one.name == name)
            return std::move(one);
        names.emplace_back(one.name);
    }
    if (names.empty())
        return fail(Errc::link_not_found,
                    fmt::format("there is no CAN interface '{}', and none at all: plug the adapter in, or load its "
                                "driver; one that speaks SLCAN is reached with slcan:/dev/ttyACM0?bitrate=1000000",
                                name));
    const std::string nearest = did_you_mean(name, names);
    return fail(Errc::link_not_found,
                fmt::format("there is no CAN interface '{}'{} There {} {}.", name, nearest.empty() ? "." : nearest,
                            names.size() == 1 ? "is" : "are", fmt::join(names, ", ")));
}

std::string how_to_bring_up(const CanInterface& interface)
{
    const bool has_bits = interface.kind != "vcan" && interface.kind != "vxcan";
    return fmt::format("ip link set {} up{}", interface.name,
                       has_bits && interface.bit_rate == 0 ? " type can bitrate 1000000" : "");
}

} // namespace sinew::link
