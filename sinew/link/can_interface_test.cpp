#include "sinew/link/can_interface.hpp"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>

namespace sinew::link {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class T>
Bytes bytes_of(const T& value)
{
    Bytes out(sizeof value);
    std::memcpy(out.data(), &value, sizeof value);
    return out;
}

Bytes operator+(Bytes a, const Bytes& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

Bytes attribute(std::uint16_t type, const Bytes& payload)
{
    const auto size = static_cast<std::uint16_t>(RTA_LENGTH(payload.size()));
    Bytes out = bytes_of(rtattr{.rta_len = size, .rta_type = type}) + payload;
    out.resize(RTA_ALIGN(out.size()));
    return out;
}

Bytes text(std::string_view value)
{
    Bytes out(value.begin(), value.end());
    out.push_back(0);
    return out;
}

Bytes message(std::uint16_t hardware, std::uint32_t flags, const Bytes& attributes)
{
    const Bytes body = bytes_of(ifinfomsg{.ifi_type = hardware, .ifi_index = 3, .ifi_flags = flags}) + attributes;
    const nlmsghdr header{.nlmsg_len = static_cast<std::uint32_t>(NLMSG_LENGTH(body.size())),
                          .nlmsg_type = RTM_NEWLINK};
    return bytes_of(header) + body;
}

/// A can0 at 1 Mbit/s that has seen errors.
Bytes can0()
{
    const can_bittiming timing{.bitrate = 1'000'000};
    const can_berr_counter errors{.txerr = 130, .rxerr = 7};
    const Bytes data = attribute(IFLA_CAN_BITTIMING, bytes_of(timing)) +
                       attribute(IFLA_CAN_STATE, bytes_of(std::uint32_t{CAN_STATE_ERROR_PASSIVE})) +
                       attribute(IFLA_CAN_RESTART_MS, bytes_of(std::uint32_t{100})) +
                       attribute(IFLA_CAN_BERR_COUNTER, bytes_of(errors));
    const can_device_stats statistics{.bus_off = 2, .restarts = 1};
    const Bytes info = attribute(IFLA_INFO_KIND, text("can")) + attribute(IFLA_INFO_XSTATS, bytes_of(statistics)) +
                       attribute(IFLA_INFO_DATA | NLA_F_NESTED, data);
    return message(ARPHRD_CAN, IFF_UP | IFF_RUNNING,
                   attribute(IFLA_IFNAME, text("can0")) + attribute(IFLA_TXQLEN, bytes_of(std::uint32_t{10})) +
                       attribute(IFLA_LINKINFO, info));
}

TEST(CanInterfaces, TellWhatTheKernelSaid)
{
    const auto found = parse_can_interface(can0());
    ASSERT_TRUE(found);
    EXPECT_EQ(found->name, "can0");
    EXPECT_EQ(found->index, 3);
    EXPECT_EQ(found->kind, "can");
    EXPECT_TRUE(found->is_up);
    EXPECT_EQ(found->bit_rate, 1'000'000u);
    EXPECT_EQ(found->tx_queue, 10u);
    EXPECT_EQ(found->restart_ms, 100u);
    EXPECT_EQ(to_word(found->state), "error-passive");
    EXPECT_EQ(found->tx_errors, 130);
    EXPECT_EQ(found->rx_errors, 7);
    EXPECT_EQ(found->bus_offs, 2u);
    EXPECT_EQ(found->restarts, 1u);
    EXPECT_EQ(how_to_bring_up(*found), "ip link set can0 up");
}

TEST(CanInterfaces, AnInterfaceWithoutARateNeedsOneToComeUp)
{
    const Bytes info = attribute(IFLA_INFO_KIND, text("can"));
    const auto found = parse_can_interface(
        message(ARPHRD_CAN, 0, attribute(IFLA_IFNAME, text("can1")) + attribute(IFLA_LINKINFO, info)));
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->is_up);
    EXPECT_EQ(how_to_bring_up(*found), "ip link set can1 up type can bitrate 1000000");
}

TEST(CanInterfaces, VirtualOnesHaveNeitherRateNorQueue)
{
    const Bytes info = attribute(IFLA_INFO_KIND, text("vcan"));
    const auto found = parse_can_interface(message(ARPHRD_CAN, IFF_UP,
                                                   attribute(IFLA_IFNAME, text("vcan0")) +
                                                       attribute(IFLA_TXQLEN, bytes_of(std::uint32_t{1000})) +
                                                       attribute(IFLA_LINKINFO, info)));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->bit_rate, 0u);
    EXPECT_EQ(found->tx_queue, 0u);
    EXPECT_EQ(found->state, CanState::unknown);
    EXPECT_EQ(how_to_bring_up(*found), "ip link set vcan0 up");
}

TEST(CanInterfaces, OtherInterfacesAreNone)
{
    EXPECT_FALSE(parse_can_interface(message(ARPHRD_ETHER, IFF_UP, attribute(IFLA_IFNAME, text("eth0")))));
}

TEST(CanInterfaces, AMessageThatIsCutShortReadsNothingBeyondItsEnd)
{
    const Bytes whole = can0();
    for (std::size_t size = 0; size < whole.size(); ++size) {
        Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)); // its own heap, for the sanitizer
        EXPECT_FALSE(parse_can_interface(part)) << size;
        if (size < NLMSG_LENGTH(sizeof(ifinfomsg)))
            continue;
        const auto shorter = static_cast<std::uint32_t>(size);
        std::memcpy(part.data(), &shorter, sizeof shorter); // and one whose header says so
        EXPECT_TRUE(parse_can_interface(part)) << size;
    }
}

TEST(CanInterfaces, TheKernelAnswers)
{
    const auto all = can_interfaces();
    ASSERT_TRUE(all) << to_sentence(all.error());
    for (const CanInterface& one : *all)
        EXPECT_FALSE(one.name.empty());
}

} // namespace
} // namespace sinew::link
