#include "sinew/bus/agree.hpp"
#include "tests/bus/matching_rmd.hpp"

/// What nobody can tell from the bytes: measured beside what docs/guide/residual-risk.md computes.
namespace sinew::tests {
namespace {

/// Measured beside computed, for chances large enough to be seen.
void print_risk(std::string_view what, const Tally& tally, std::uint64_t wrong, double computed)
{
    fmt::print("residual {:<58} measured {:.2e} computed {:.2e}\n", what, tally.share(wrong), computed);
}

/// Of a reply of two bytes of which so many are not known beforehand: a bit of one flips, or noise comes between them.
double computed_bare(double flip, double add, int open_bytes = 2)
{
    return 1.0 - std::pow(1.0 - flip, open_bytes) * (1.0 - add);
}

/// Over what `run_sam` asks: of 33 requests 24 bring two bytes of which nothing is known, 8 the id and one byte, and
/// one nothing. Where a command is damaged itself, which happens to one in so many, nothing comes back.
double computed_sam(double flip, double add)
{
    constexpr double command_bytes = 5.5; // 4 and 7
    const double heard = std::pow(1.0 - flip, command_bytes);
    return (16 * computed_bare(flip, add) + heard * (8 * computed_bare(flip, add) + 8 * computed_bare(flip, add, 1))) /
           33;
}

TEST(ResidualRisk, OfDamagedBareRepliesIsWhatIsComputed)
{
    constexpr double often = 5e-3;
    const Tally flipped = run_sam(exchanges() / 4, {.bytes = {.flip_bit = often}});
    print_risk("sam, a bit of a reply flips", flipped, flipped.damaged, computed_sam(often, 0));
    flipped.expect_near(flipped.damaged, computed_sam(often, 0));
    const Tally added = run_sam(exchanges() / 4, {.bytes = {.add_byte = often}});
    print_risk("sam, noise within a reply", added, added.damaged, computed_sam(0, often));
    added.expect_near(added.damaged, computed_sam(0, often));
    bus::Settings twice = settings;
    twice.double_read = true;
    const Tally doubled = run_sam(exchanges() / 4, {.bytes = {.flip_bit = often}}, twice);
    // Commands are not asked twice: half of the requests. Of the reads those go wrong in which both answers do alike.
    const double both = computed_bare(often, 0) * often / 8;
    const double computed = 0.5 * flipped.share(flipped.far_off) + both;
    print_risk("sam, double read, a bit flips: far off, commands included", doubled, doubled.far_off, computed);
    EXPECT_LT(doubled.far_off, flipped.far_off);
}

TEST(ResidualRisk, OfDamagedFramesIsTwoFlipsThatTheChecksumCannotTell)
{
    constexpr double often = 2e-2;
    const Tally flipped = run_nuri(exchanges() / 4, {.bytes = {.flip_bit = often}});
    // Two of the seven bytes that are not looked at otherwise (six of payload, the checksum); the same bit of both, one
    // up and one down, or bit 7; and none of the ten others.
    constexpr double pairs = 21.0;
    constexpr double alike = 1.0 / 8.0 * (7.0 / 8.0 * 0.5 + 1.0 / 8.0);
    const double computed = 16.0 / 17.0 * pairs * often * often * std::pow(1.0 - often, 10) * alike;
    print_risk("nuri, two bits of a frame flip", flipped, flipped.damaged, computed);
    flipped.expect_near(flipped.damaged, computed);
}

/// How many answers are wrong where one is: on SAM the answer that it displaces comes while the next request waits, and
/// so on, until the line rests (behind one exchange in three; an exchange has 2.5 requests) or the request is one whose
/// answer is known beforehand, and not just the same.
constexpr double sam_chain = 1.0 / (1.0 - (1.0 - 0.3 / 2.5) * (25.0 + 8.0 / 8.0) / 33.0);

/// Of 25 requests 24 ask one of 8 devices one of 3 things; the last brings four torque answers more.
constexpr double rmd_kinds = 25.0 * 25.0 / (20 + 4 * 2 * 2);

/// An answer that comes later than `late_max`, some time up to four times that, and then falls just where one like it
/// is waited for: on SAM any, on Nuri and RMD the same of the same device.
TEST(ResidualRisk, OfAnswersLaterThanExpectedIsAtMostWhatIsComputed)
{
    constexpr double often = 5e-2;
    constexpr double beyond = 0.75;
    const sim::WireFaults late{.delay_reply = often, .reply_delay = 4 * settings.late_max};
    const auto compare = [&](std::string_view what, const Tally& tally, double kinds) {
        const double answers = 1.0 + often; // what comes late is asked once more
        const double computed = often * answers * beyond * tally.waiting() / kinds;
        print_risk(what, tally, tally.foreign + tally.unmarked, computed);
        tally.expect_at_most(tally.foreign + tally.unmarked, computed);
    };
    const Tally sam = run_sam(exchanges() / 4, {.bytes = late});
    compare("sam, an answer comes later than late_max", sam, 1 / sam_chain);
    bus::Settings twice = settings;
    twice.double_read = true;
    const Tally doubled = run_sam(exchanges() / 4, {.bytes = late}, twice);
    const auto wrong = [](const Tally& tally) { return tally.foreign + tally.unmarked; };
    print_risk("sam, double read, later than late_max, commands included", doubled, wrong(doubled),
               0.5 * sam.share(wrong(sam)));
    doubled.expect_at_most(wrong(doubled), sam.share(wrong(sam)));
    const Tally nuri = run_nuri(exchanges() / 4, {.bytes = late});
    compare("nuri, an answer comes later than late_max", nuri, 16);
    EXPECT_EQ(nuri.foreign, 0U);
    const Tally rmd = run_rmd(exchanges() / 4, {.frames = late});
    compare("rmd, an answer comes later than late_max", rmd, rmd_kinds);
    EXPECT_EQ(rmd.foreign, 0U);
}

/// Another master asks the same devices the same.
TEST(ResidualRisk, OfAnotherMasterIsAtMostWhatIsComputed)
{
    constexpr double often = 5e-2;
    TracedFaults faults{.other_master = often};
    for (const auto& request : sam_choice(50us))
        faults.others.push_back(request.frame);
    const Tally sam = run_sam(exchanges() / 4, faults);
    const double computed = often * sam.waiting() * sam_chain;
    print_risk("sam, another master asks", sam, sam.foreign + sam.unmarked, computed);
    sam.expect_at_most(sam.foreign + sam.unmarked, computed);

    faults.others.clear();
    for (const auto& request : nuri_choice())
        faults.others.push_back(request.frame);
    const Tally nuri = run_nuri(exchanges() / 4, faults);
    print_risk("nuri, another master asks", nuri, nuri.foreign + nuri.unmarked, 0);
    EXPECT_EQ(nuri.foreign, 0U);
    EXPECT_LE(nuri.oldest, 100us) << "no older than the device takes to answer";
    const Tally rmd = run_rmd(exchanges() / 4, {.other_master = often});
    print_risk("rmd, another master asks", rmd, rmd.foreign + rmd.unmarked, 0);
    EXPECT_EQ(rmd.foreign, 0U);
    // Of a batch of eight each may be for several motors, four of which answer; and one frame has begun before.
    EXPECT_LE(rmd.oldest, 100us + (8 * 5 + 2) * bus::frame_time({.can = true, .bit_rate = 1'000'000}, 8))
        << "no older than an answer that lets a whole batch and what it brings go first";
}

/// A frame that is sent once more: an answer that comes again, or a request that is answered twice.
TEST(ResidualRisk, OfFramesThatCanRepeatsIsAtMostWhatIsComputed)
{
    constexpr double often = 5e-2;
    const Tally rmd = run_rmd(exchanges() / 4, {.frames = {.add_byte = often}});
    const double computed = 2 * often * rmd.waiting() / rmd_kinds;
    print_risk("rmd, a frame is repeated", rmd, rmd.foreign + rmd.unmarked, computed);
    rmd.expect_at_most(rmd.unmarked, computed);
    EXPECT_EQ(rmd.foreign, 0U);
    EXPECT_GT(rmd.unmarked, 0U) << "the test never saw a repeated frame, so it proves nothing about them";
}

} // namespace
} // namespace sinew::tests
