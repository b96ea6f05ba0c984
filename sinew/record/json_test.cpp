#include "sinew/record/json.hpp"

#include "sinew/record/little_endian.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace sinew::record {
namespace {

TEST(Json, ReadsWhatItWrote)
{
    const std::string nasty = "a \"quote\", a \\, a\nline, \x01, \xC2\xB0";
    std::string out;
    {
        JsonWriter json(out);
        json.number("position_rad", 0.1 + 0.2);
        json.number("tiny", -1e-300);
        json.whole("can_id", 321);
        json.flag("enabled", true);
        json.text("text", nasty);
        json.hex("bytes", bytes_of("\xFF\x0A"));
        json.number("not_there", std::nan(""));
    }
    const auto in = JsonFields::parse(out);
    ASSERT_TRUE(in) << out;
    EXPECT_EQ(in->number("position_rad"), 0.1 + 0.2);
    EXPECT_EQ(in->number("tiny"), -1e-300);
    EXPECT_EQ(in->number("can_id"), 321);
    EXPECT_EQ(in->flag("enabled"), true);
    ASSERT_NE(in->text("text"), nullptr);
    EXPECT_EQ(*in->text("text"), nasty);
    EXPECT_EQ(*in->text("bytes"), "FF 0A");
    EXPECT_FALSE(in->number("not_there"));
    EXPECT_FALSE(in->number("enabled"));
}

TEST(Json, WritesNothingThatIsNoUtf8)
{
    for (const std::string_view bad : {"\xFF", "\xC0\x80", "\xE2\x82", "\xED\xA0\x80", "\xF5\x80\x80\x80"}) {
        std::string out;
        JsonWriter(out).text("t", fmt::format("a{}b", bad));
        EXPECT_NE(out.find("\xEF\xBF\xBD"), std::string::npos);
        EXPECT_EQ(out.find(bad), std::string::npos);
        EXPECT_TRUE(JsonFields::parse(out));
    }
}

TEST(Json, ReadsEscapesAndPassesOverWhatIsDeeper)
{
    const auto in =
        JsonFields::parse(R"( { "a" : "\u00b0\ud83d\ude00\t\/" , "b" : [1,{"c":"]"}] , "n":null,"d" : -2.5e1 } )");
    ASSERT_TRUE(in);
    EXPECT_EQ(*in->text("a"), "\xC2\xB0\xF0\x9F\x98\x80\t/");
    EXPECT_EQ(in->number("d"), -25);
    EXPECT_EQ(in->text("b"), nullptr);
    EXPECT_TRUE(JsonFields::parse("{}"));
}

TEST(Json, RefusesWhatIsNoObject)
{
    for (const std::string_view bad :
         {"", "{", "[]", "{\"a\"}", "{\"a\":}", "{\"a\":1", "{\"a\":1,}", "{\"a\":\"x}", "{\"a\":[1}", "{} x",
          "{\"a\":\"\\x\"}", "{\"a\":\"\\u12\"}", "{\"a\":\"\n\"}", "{\"a\":nan}", "{\"a\":1e999}"})
        EXPECT_FALSE(JsonFields::parse(bad)) << bad;
}

} // namespace
} // namespace sinew::record
