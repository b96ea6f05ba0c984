#include "tests/bus/matching_rmd.hpp"

/// Whatever happens on the wire, a call returns the data of the device and the message that it asked, and says so when
/// they may be older. Every fault is on.
namespace sinew::tests {
namespace {

void expect_of_all(const Tally& tally)
{
    tally.expect_none_wrong();
    EXPECT_GT(tally.right, tally.asked / 2);
}

/// Of the damage that the bytes do not show no more than is computed (docs/guide/residual-risk.md): of an answer two
/// bytes and what comes between them, of a request the highest bit of four bytes, which the checksum leaves out.
void expect_of_sam(const Tally& tally)
{
    expect_of_all(tally);
    const auto& bytes = all_faults.bytes;
    tally.expect_at_most(tally.damaged, 2 * bytes.flip_bit + bytes.add_byte);
    tally.expect_at_most(tally.by_mistake, 4 * bytes.flip_bit / 8);
    tally.expect_at_most(tally.invented, bytes.add_byte * bytes.add_byte);
    EXPECT_GT(tally.quarantines, 0U);
    EXPECT_GT(tally.losses, 0U);
}

/// A late answer and another one at once are taken apart here, byte by byte, and sometimes make a frame; on a wire they
/// destroy each other.
void expect_of_nuri(const Tally& tally)
{
    expect_of_all(tally);
    tally.expect_at_most(tally.damaged, 2e-4);
    tally.expect_at_most(tally.by_mistake, 0);
    EXPECT_GT(tally.losses, 0U);
}

TEST(Matching, OfSamsBareRepliesNeverReturnsAnothersData)
{
    const Tally tally = run_sam(exchanges() / 4, all_faults);
    tally.print("sam");
    expect_of_sam(tally);
}

TEST(Matching, OfSamsBareRepliesNeverReturnsAnothersDataBehindAnAdapterThatHearsItself)
{
    TracedFaults faults = all_faults;
    faults.echo = true;
    const Tally tally = run_sam(exchanges() / 8, faults);
    tally.print("sam, echo");
    expect_of_sam(tally);
}

TEST(Matching, OfNuriNeverReturnsAnothersData)
{
    // Often late by little more than the margin: so the answer to a request often comes while it is asked again.
    TracedFaults faults = all_faults;
    faults.bytes.delay_reply = 5e-2;
    faults.bytes.reply_delay = 8ms;
    const Tally tally = run_nuri(exchanges() / 4, faults);
    tally.print("nuri");
    expect_of_nuri(tally);
    EXPECT_GT(tally.marked, 0U) << "the test never saw an older answer, so it proves nothing about them";
}

TEST(Matching, OfNuriNeverReturnsAnothersDataBehindAnAdapterThatHearsItself)
{
    TracedFaults faults = all_faults;
    faults.echo = true;
    const Tally tally = run_nuri(exchanges() / 8, faults);
    tally.print("nuri, echo");
    expect_of_nuri(tally);
}

TEST(Matching, OfRmdNeverReturnsAnothersData)
{
    const Tally tally = run_rmd(
        exchanges() / 4, {.frames = {.flip_bit = 1e-3, .drop_byte = 1e-3, .delay_reply = 5e-3, .reply_delay = 50ms},
                          .hang_up = 5e-3,
                          .unasked = 5e-3});
    tally.print("rmd");
    expect_of_all(tally);
    EXPECT_GT(tally.marked, 0U);
    EXPECT_GT(tally.losses, 0U);
}

} // namespace
} // namespace sinew::tests
