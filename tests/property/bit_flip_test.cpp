#include "tests/property/sides.hpp"

#include <gtest/gtest.h>
#include <map>
#include <set>

/// One flipped bit in a frame.
namespace sinew::property {
namespace {

using namespace wire;
using test::Random;

/// The message that reads a frame, or nullptr.
const MessageInfo* reader(const test::Family& family, Direction direction, const Frame& frame)
{
    for (const auto* message : family.manual.messages)
        if (message->side(direction).exists() && decode(*message, direction, frame))
            return message;
    return nullptr;
}

Frame flipped(Frame frame, std::size_t byte, int bit)
{
    frame.data[byte] = static_cast<std::uint8_t>(frame.data[byte] ^ 1U << bit);
    return frame;
}

std::uint64_t flip_cases()
{
    return test::cases() / 100;
}

TEST(FlippedBit, IsNeverAcceptedByNuri)
{
    Random random("nuri");
    for (const auto& side : all_sides()) {
        if (side.family->name != "nuri")
            continue;
        for (std::uint64_t i = 0; i < flip_cases(); ++i) {
            const Sample x = sample(*side.message, side.direction, random);
            const auto frame = encode(*side.message, side.direction, x.id, x.values, x.options);
            ASSERT_TRUE(frame);
            for (std::size_t byte = 0; byte < frame->size; ++byte)
                for (int bit = 0; bit < 8; ++bit) {
                    const Frame broken = flipped(*frame, byte, bit);
                    ASSERT_EQ(reader(*side.family, side.direction, broken), nullptr) << to_hex(broken.bytes());
                    const Scan scan = side.family->protocol->find_request(broken.bytes(), true);
                    ASSERT_FALSE(scan.skip == 0 && scan.size != 0) << to_hex(broken.bytes());
                }
        }
    }
}

/// SAM's checksum has no bit 7 (A.1 of the manual). A flipped bit 7 passes in these bytes of these requests, if the
/// value that it makes is one that may travel:
/// - quick control: byte 1, where it makes another torque level or mode of the same four bytes; byte 2, a position or
///   a byte that does not matter;
/// - everything else: an id (byte 3 of standard commands), whole-byte values that are sent once, bytes that do not
///   matter, instructions of motion programs, the high byte of a standard position, and the fifth byte of 199 and 202,
///   whose bit 7 is masked (S41).
/// Never: the header, the opcode, the checksum, values that are sent twice, and septets.
const std::map<std::string_view, std::set<std::size_t>>& unprotected()
{
    static const std::map<std::string_view, std::set<std::size_t>> bytes{
        {"quick-position-control", {1, 2}},
        {"quick-read-status", {1, 2}},
        {"quick-passive-mode", {1}},
        {"quick-wheel-mode", {1}},
        {"quick-brake-mode", {1}},
        {"quick-set-baud-rate", {}},
        {"quick-set-runtime-pd-gain", {3, 4}},
        {"quick-set-id", {}},
        {"quick-set-overload", {}},
        {"quick-read-overload", {3, 4}},
        {"quick-set-boundary", {3, 4}},
        {"quick-read-boundary", {3, 4}},
        {"quick-write-external-port", {}},
        {"quick-read-external-ad", {3, 4}},
        {"quick-write-motion-data", {4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19}},
        {"quick-read-motion-data", {3, 4}},
        {"set-id", {3}},
        {"set-baud-rate", {3}},
        {"set-ctrl-speed", {3}},
        {"read-ctrl-speed", {3, 4, 5}},
        {"set-ctrl-torque", {3}},
        {"read-ctrl-torque", {3, 4, 5}},
        {"set-ctrl-accel", {3}},
        {"read-ctrl-accel", {3, 4, 5}},
        {"set-ctrl-decel", {3}},
        {"read-ctrl-decel", {3, 4, 5}},
        {"read-current-speed", {3, 4, 5}},
        {"read-current-accel", {3, 4, 5}},
        {"read-current-load", {3, 4, 5}},
        {"read-current-position", {3, 4, 5}},
        {"set-pd-gain", {3, 4, 5}},
        {"read-pd-gain", {3, 4, 5}},
        {"set-runtime-pd-gain", {3, 4, 5}},
        {"set-overload", {3}},
        {"read-overload", {3, 4, 5}},
        {"set-boundary", {3, 4, 5}},
        {"read-boundary", {3, 4, 5}},
        {"set-i-gain", {3}},
        {"read-i-gain", {3, 4, 5}},
        {"set-runtime-i-gain", {3}},
        {"set-drive-mode", {3}},
        {"read-drive-mode", {3, 4, 5}},
        {"set-avg-torque", {3}},
        {"read-avg-torque", {3, 4, 5}},
        {"read-input-voltage", {3, 4, 5}},
        {"write-external-port", {3}},
        {"read-external-ad", {3, 4, 5}},
        {"write-motion-data", {3, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20}},
        {"read-motion-data", {3, 4, 5}},
        {"ping", {3, 4, 5}},
        {"read-firmware-version", {3, 4, 5}},
        {"offset-control", {3}},
        {"read-temperature-error", {3, 4, 5}},
        {"special-control", {3, 5}},
        {"position-control", {3, 4}},
        {"precise-position-control", {3, 5}},
        {"read-precise-position", {3, 4, 5, 6}},
    };
    return bytes;
}

TEST(FlippedBit, PassesInSamRequestsOnlyInBitSevenOfTheListedBytes)
{
    Random random("sam");
    std::map<std::string_view, std::set<std::size_t>> passed;
    for (const auto& side : all_sides()) {
        if (side.family->name != "sam" || side.direction != Direction::request)
            continue;
        auto& bytes = passed[side.message->name()];
        for (std::uint64_t i = 0; i < flip_cases() + 300; ++i) {
            const Sample x = sample(*side.message, side.direction, random);
            const auto frame = encode(*side.message, side.direction, x.id, x.values);
            ASSERT_TRUE(frame);
            for (std::size_t byte = 0; byte < frame->size; ++byte)
                for (int bit = 0; bit < 8; ++bit) {
                    const Frame broken = flipped(*frame, byte, bit);
                    if (reader(*side.family, side.direction, broken) == nullptr)
                        continue;
                    ASSERT_EQ(bit, 7) << side.message->name() << " " << to_hex(broken.bytes());
                    bytes.insert(byte);
                }
        }
    }
    for (const auto& [message, bytes] : passed) {
        const auto listed = unprotected().find(message);
        ASSERT_NE(listed, unprotected().end()) << message;
        EXPECT_EQ(bytes, listed->second) << message;
    }
    EXPECT_EQ(passed.size(), unprotected().size());
}

} // namespace
} // namespace sinew::property
