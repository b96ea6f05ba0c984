#include "sinew/family/sam/motion_text.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace sinew::sam {
namespace {

std::string bytes_of(std::string_view text)
{
    const auto program = assemble(text, "p.motion");
    if (!program)
        return to_sentence(program.error());
    std::string out;
    for (const auto& [first, second] : program->instructions) {
        constexpr char digits[] = "0123456789ABCDEF";
        for (const auto byte : {first, second}) {
            out += digits[byte >> 4];
            out += digits[byte & 15];
            out += ' ';
        }
    }
    return out;
}

TEST(SamMotionText, IsTheExampleOfTheManual)
{
    EXPECT_EQ(bytes_of("go 82\nwait 266ms\ngo 172\nwait 266ms\n"), "10 52 31 0A 10 AC 31 0A ");
}

TEST(SamMotionText, HasEveryInstruction)
{
    EXPECT_EQ(bytes_of("go 0 level 4 # weakest\n\n  passive\nbrake\nwheel cw 5\nwheel ccw 15"),
              "14 00 21 00 22 00 24 05 23 0F ");
    EXPECT_EQ(bytes_of("outputs none\noutputs 1\noutputs 2\noutputs 1 2"), "40 00 40 01 40 02 40 03 ");
    EXPECT_EQ(bytes_of("until position = 9\nuntil ad > 9\nuntil ad < 9\nuntil position >= 9\nuntil ad <= 254"),
              "51 09 62 09 63 09 54 09 65 FE ");
    EXPECT_EQ(bytes_of("repeat forever\nrepeat 254\nend"), "70 00 70 FE 80 00 ");
}

TEST(SamMotionText, CountsAnglesFromTheMiddle)
{
    EXPECT_EQ(bytes_of("go 0deg"), "10 7F ");
    EXPECT_EQ(bytes_of("go 108deg"), "10 E3 ");
    EXPECT_EQ(bytes_of("go -108deg"), "10 1B ");
}

TEST(SamMotionText, TellsWhereAProgramSendsTheShaftAndFromWhichLine)
{
    const auto program = assemble("# fast\nwheel ccw 1\n\ngo 108deg level 2\nwait 16ms\nwheel cw 0", "p");
    ASSERT_TRUE(program);
    EXPECT_EQ(program->places, (std::vector<std::string>{"p:2", "p:4", "p:5", "p:6"}));
    const auto& all = program->instructions;
    EXPECT_TRUE(turns_on(all[0]));
    EXPECT_FALSE(goes_to_rad(all[0]));
    EXPECT_DOUBLE_EQ(goes_to_rad(all[1]).value(), 0.6 * std::numbers::pi); // 108 deg
    EXPECT_FALSE(turns_on(all[1]) || turns_on(all[2]));
    EXPECT_FALSE(turns_on(all[3])); // it stops
    EXPECT_FALSE(goes_to_rad(all[2]));
}

TEST(SamMotionText, SaysWhatIsWrongAndWhere)
{
    for (const auto& [text, said] :
         {std::pair{"go 82\ngo 255", "p.motion:2: go takes"},
          {"wait 511ms", "take 510 or 512"},
          {"wait 4095ms", "take 4094 or 4094"},
          {"wait 4096ms", "up to 4094ms"},
          {"until position ~ 3", "until takes"},
          {"wheel cw 16", "0 to 15"},
          {"outputs 3", "outputs takes"},
          {"repeat 0", "1 to 254"},
          {"gi 3", "did you mean go"},
          {"end 3", "end takes nothing"},
          {"# nothing", "no instruction"},
          {"go 200deg", "go takes"},
          {"go 1 level 5", "go takes"},
          {"end\nend\nend\nend\nend\nend\nend\nend\nend", "p.motion:9: a program has at most 8"}})
        EXPECT_NE(bytes_of(text).find(said), std::string::npos) << text << ": " << bytes_of(text);
}

TEST(SamMotionText, ComesBackFromItsBytes)
{
    int explained = 0;
    for (int first = 0; first < 256; ++first)
        for (int second = 0; second < 255; ++second) {
            const wire::Pair pair{static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second)};
            const auto text = disassemble({&pair, 1});
            if (text.starts_with('#'))
                continue;
            const auto again = assemble(text, "p");
            ASSERT_TRUE(again) << text << to_sentence(again.error());
            ++explained;
            // What an instruction does not look at is not kept.
            EXPECT_EQ(disassemble(again->instructions), text);
        }
    EXPECT_GT(explained, 10'000);
}

} // namespace
} // namespace sinew::sam
