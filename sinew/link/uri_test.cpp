#include "sinew/link/uri.hpp"

#include <gtest/gtest.h>

namespace sinew::link {
namespace {

std::string refusal(std::string_view text)
{
    const auto uri = parse_uri(text);
    if (uri)
        return "accepted";
    EXPECT_EQ(uri.error().code, Errc::bad_uri);
    return to_sentence(uri.error());
}

TEST(Uri, KeepsEveryPartOfEveryFormInUse)
{
    const auto serial = parse_uri("serial:/dev/ttyUSB0?baud=1500000");
    ASSERT_TRUE(serial);
    EXPECT_EQ(serial->scheme, "serial");
    EXPECT_EQ(serial->target, "/dev/ttyUSB0");
    EXPECT_EQ(serial->option("baud"), "1500000");
    EXPECT_EQ(serial->number("baud").value(), 1500000u);

    const auto rs485 = parse_uri("rs485:/dev/ttyS1?baud=115200&echo=on");
    ASSERT_TRUE(rs485);
    EXPECT_EQ(rs485->options.size(), 2u);
    EXPECT_EQ(rs485->option("echo"), "on");

    const auto tcp = parse_uri("tcp://192.168.0.7:4001");
    ASSERT_TRUE(tcp);
    EXPECT_EQ(tcp->target, "192.168.0.7:4001");
    EXPECT_FALSE(tcp->option("baud"));
    EXPECT_FALSE(tcp->number("baud").value());

    const auto sim = parse_uri("sim:arm.toml#left");
    ASSERT_TRUE(sim);
    EXPECT_EQ(sim->target, "arm.toml");
    EXPECT_EQ(sim->fragment, "left");
}

TEST(Uri, BecomesTheSameTextAgain)
{
    for (const auto* text : {"serial:/dev/ttyUSB0?baud=1500000", "rs485:/dev/ttyS1?baud=115200&echo=on",
                             "tcp://[::1]:4001?baud=9600", "slcan:/dev/ttyACM0?bitrate=1000000", "pty:/dev/pts/3",
                             "sim:arm.toml#left", "sim:arm.toml?clock=real#left"}) {
        const auto uri = parse_uri(text);
        ASSERT_TRUE(uri) << text;
        EXPECT_EQ(to_string(*uri), text);
    }
}

TEST(Uri, TakesOptionsAfterTheFragmentToo)
{
    const auto uri = parse_uri("sim:arm.toml#left?clock=real");
    ASSERT_TRUE(uri);
    EXPECT_EQ(uri->fragment, "left");
    EXPECT_EQ(uri->option("clock"), "real");
}

TEST(Uri, SaysWhatToWriteWhenTheSchemeIsMissing)
{
    EXPECT_EQ(refusal("/dev/ttyUSB0"), "'/dev/ttyUSB0' has no scheme: write serial:/dev/ttyUSB0");
    EXPECT_EQ(refusal("192.168.0.7:4001"), "'192.168.0.7:4001' has no scheme: write tcp://192.168.0.7:4001");
    EXPECT_NE(refusal("ttyUSB0").find("SCHEME:TARGET"), std::string::npos);
    EXPECT_NE(refusal("").find("SCHEME:TARGET"), std::string::npos);
    EXPECT_NE(refusal(":x").find("SCHEME:TARGET"), std::string::npos);
}

TEST(Uri, RefusesWhatIsMissingOrDoubled)
{
    EXPECT_NE(refusal("serial:").find("names no target"), std::string::npos);
    EXPECT_NE(refusal("serial:?baud=1").find("names no target"), std::string::npos);
    EXPECT_EQ(refusal("serial:/dev/x?baud"), "option 'baud' is not written NAME=VALUE, such as baud=1500000");
    EXPECT_EQ(refusal("serial:/dev/x?baud="), "option 'baud=' is not written NAME=VALUE, such as baud=1500000");
    EXPECT_EQ(refusal("serial:/dev/x?baud=1&baud=2"), "option 'baud' is given twice");
    EXPECT_NE(refusal("sim:arm.toml#").find("one name after one '#'"), std::string::npos);
    EXPECT_NE(refusal("sim:arm.toml#a#b").find("one name after one '#'"), std::string::npos);
}

TEST(Uri, TakesOnlyWholePositiveNumbers)
{
    for (const auto* value : {"0", "-9600", "1.5M", "9600bd", "+1", "0x10", "4294967296"}) {
        const auto uri = parse_uri(std::string{"serial:/dev/x?baud="} + value);
        ASSERT_TRUE(uri) << value;
        const auto number = uri->number("baud");
        ASSERT_FALSE(number) << value;
        EXPECT_EQ(number.error().code, Errc::bad_uri);
        EXPECT_EQ(to_sentence(number.error()),
                  std::string{"option baud must be a whole positive number, not '"} + value + "'");
    }
    EXPECT_EQ(parse_uri("serial:/dev/x?baud=4294967295")->number("baud").value(), 4294967295u);
}

} // namespace
} // namespace sinew::link
