#include "sinew/link/can_error.hpp"

#include <gtest/gtest.h>

namespace sinew::link {
namespace {

using Words = std::vector<std::string>;

wire::Frame error(std::uint32_t kind, std::array<std::uint8_t, 8> data = {})
{
    wire::Frame frame{.can_id = kind, .size = 8};
    std::ranges::copy(data, frame.data.begin());
    return frame;
}

/// The numbers are those of linux/can/error.h, written out, so that a wrong row shows.
TEST(CanError, EveryClassHasItsWord)
{
    const std::pair<std::uint32_t, std::string> classes[] = {
        {0x001, "send-timeout"},   {0x002, "arbitration-lost"}, {0x004, "controller-problem"},
        {0x008, "protocol-error"}, {0x010, "transceiver"},      {0x020, "no-acknowledgement"},
        {0x040, "bus-off"},        {0x080, "bus-error"},        {0x100, "restarted"},
        {0x800, "class-0x800"},
    };
    for (const auto& [kind, word] : classes)
        EXPECT_EQ(can_error_words(error(kind)), Words{word}) << kind;
}

TEST(CanError, TheStateOfTheControllerIsNamed)
{
    const std::pair<std::uint8_t, std::string> states[] = {
        {0x01, "receive-overflow"},      {0x02, "send-overflow"},           {0x04, "error-warning-receiving"},
        {0x08, "error-warning-sending"}, {0x10, "error-passive-receiving"}, {0x20, "error-passive-sending"},
        {0x40, "error-active"},          {0x80, "controller-problem"},
    };
    for (const auto& [bits, word] : states)
        EXPECT_EQ(can_error_words(error(0x004, {0, bits})), Words{word}) << int{bits};
    EXPECT_EQ(can_error_words(error(0x004, {0, 0x30})), (Words{"error-passive-receiving", "error-passive-sending"}));
}

TEST(CanError, WhatIsWrongWithAFrameIsNamed)
{
    const std::pair<std::uint8_t, std::string> problems[] = {
        {0x01, "bit-error"},   {0x02, "form-error"}, {0x04, "stuff-error"},     {0x08, "bit-0-error"},
        {0x10, "bit-1-error"}, {0x20, "overload"},   {0x40, "error-announced"}, {0x80, "while-sending"},
    };
    for (const auto& [bits, word] : problems)
        EXPECT_EQ(can_error_words(error(0x008, {0, 0, bits})), Words{word}) << int{bits};
    EXPECT_EQ(can_error_words(error(0x088, {0, 0, 0x84})), (Words{"stuff-error", "while-sending", "bus-error"}));
}

TEST(CanError, AFrameWithoutTheDetailsOfItsClassIsNotReadBeyondItsEnd)
{
    wire::Frame frame = error(0x00C, {0, 0x10, 0x04});
    frame.size = 1;
    EXPECT_EQ(can_error_words(frame), (Words{"controller-problem", "protocol-error"}));
}

TEST(CanError, ItIsOneSentenceWithTheCountersOfTheController)
{
    EXPECT_EQ(can_error_sentence(error(0x040)),
              "the CAN controller reports: bus-off: it saw too many errors and fell silent");
    EXPECT_EQ(can_error_sentence(error(0x204, {0, 0x20, 0, 0, 0, 0, 136, 3})),
              "the CAN controller reports: error passive, for it sends with errors; error counters: 136 sending, 3 "
              "receiving");
    EXPECT_EQ(can_error_sentence(error(0x200, {0, 0, 0, 0, 0, 0, 1, 2})),
              "the CAN controller reports: error counters: 1 sending, 2 receiving");
    wire::Frame cut = error(0x220);
    cut.size = 7;
    EXPECT_EQ(can_error_sentence(cut), "the CAN controller reports: nobody on the bus acknowledged a frame");
}

} // namespace
} // namespace sinew::link
