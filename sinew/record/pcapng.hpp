#pragma once
#include "sinew/record/captured.hpp"

#include <string_view>

/// pcapng, which Wireshark and tshark read. One interface per bus, with its name, the family as its description, and
/// nanoseconds. CAN frames have LINKTYPE_CAN_SOCKETCAN (227), bytes of serial lines LINKTYPE_USER0 (147); the direction
/// stands in the packet flags (outbound: sent by the host), the reason why something was discarded in a comment.
///
/// Read are both byte orders, any resolution of time, and files of others: blocks and options that do not matter here
/// are passed over, packets of other link types are errors. Source: draft-ietf-opsawg-pcapng; LINKTYPE registry.
namespace sinew::record {

/// Errors name the offset of the block in the file. What breaks the chain of blocks ends the reading.
class PcapngReader final : public Reader
{
public:
    static constexpr std::uint32_t longest_block = 1U << 20U;

    void feed(std::span<const std::uint8_t> bytes) override;
    void end() override { ended_ = true; }
    std::expected<std::optional<Captured>, Error> next() override;

private:
    using Bytes = std::span<const std::uint8_t>;
    struct Interface {
        std::uint16_t link_type = 0;
        std::uint8_t resolution = 6; // powers of ten; with the highest bit set powers of two
        std::int64_t offset_s = 0;
        std::string name;
        std::string family;
    };

    std::uint32_t number(Bytes bytes, std::size_t at, std::size_t size) const;
    std::expected<Bytes, std::string> next_block(std::uint32_t& type);
    std::expected<void, std::string> read_section(Bytes body);
    std::expected<void, std::string> read_interface(Bytes body);
    std::expected<Captured, std::string> read_packet(Bytes body) const;
    std::expected<Time, std::string> time_of(const Interface& interface, std::uint64_t ticks) const;
    template <class F>
    std::expected<void, std::string> for_each_option(Bytes options, F&& use) const;

    std::vector<std::uint8_t> bytes_;
    std::size_t at_ = 0;
    std::uint64_t offset_ = 0; // of at_ in the file
    bool in_section_ = false;
    bool big_endian_ = false;
    bool ended_ = false;
    bool broken_ = false;
    std::vector<std::optional<Interface>> interfaces_; // nothing: its description could not be read
};

class PcapngWriter final : public Writer
{
public:
    std::expected<void, Error> add(const Captured& captured, std::string& out) override;

private:
    struct Known {
        std::string bus;
        std::string family;
        bool can;
        friend bool operator==(const Known&, const Known&) = default;
    };
    std::vector<Known> interfaces_;
    bool begun_ = false;
};

} // namespace sinew::record
