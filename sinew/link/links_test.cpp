#include "sinew/link/links.hpp"

#include "sinew/link/link_test_support.hpp"
#include "sinew/link/pty.hpp"
#include "sinew/link/virtual.hpp"

namespace sinew::link {
namespace {

std::string refusal(const Links& links, std::string_view uri)
{
    RealClock clock;
    const auto link = links.open(uri, clock);
    if (link)
        return "opened";
    EXPECT_EQ(link.error().code, Errc::bad_uri) << uri;
    return to_sentence(link.error());
}

TEST(Links, OpenASerialPortByItsUri)
{
    RealClock clock;
    const auto master = PtyMaster::open(9600, clock);
    ASSERT_TRUE(master);
    const auto link = Links::system().open("serial:" + (*master)->device() + "?baud=250000", clock);
    ASSERT_TRUE(link) << to_sentence(link.error());
    ASSERT_TRUE(std::holds_alternative<std::unique_ptr<ByteLink>>(*link));
    EXPECT_EQ((*master)->client_bit_rate(), 250000u);
}

TEST(Links, SuggestTheNearestSchemeAndListAll)
{
    EXPECT_EQ(
        refusal(Links::system(), "serail:/dev/ttyUSB0?baud=9600"),
        "there is no link of kind 'serail', did you mean serial? The kinds are serial, rs485, pty, tcp, slcan, can.");
    EXPECT_EQ(refusal(Links::system(), "xylophone:/dev/ttyUSB0"),
              "there is no link of kind 'xylophone'. The kinds are serial, rs485, pty, tcp, slcan, can.");
}

TEST(Links, SuggestTheNearestOption)
{
    EXPECT_EQ(refusal(Links::system(), "serial:/dev/ttyUSB0?bauds=9600"),
              "serial: has no option 'bauds', did you mean baud? It has baud, echo.");
    EXPECT_EQ(refusal(Links::system(), "slcan:/dev/ttyACM0?bit_rate=9600"),
              "slcan: has no option 'bit_rate', did you mean bitrate? It has bitrate, baud.");
    EXPECT_EQ(refusal(Links::system(), "pty:/dev/pts/0?xylophone=1"),
              "pty: has no option 'xylophone'. It has baud, echo.");
}

TEST(Links, SayWhatToWriteForABareDeviceOrHost)
{
    EXPECT_EQ(refusal(Links::system(), "/dev/ttyUSB0"), "'/dev/ttyUSB0' has no scheme: write serial:/dev/ttyUSB0");
    EXPECT_EQ(refusal(Links::system(), "localhost:4001"), "'localhost:4001' has no scheme: write tcp://localhost:4001");
}

TEST(Links, ACanInterfaceThatIsNotThereIsAnErrorWithASentence)
{
    RealClock clock;
    const auto link = Links::system().open("can:nothing0", clock);
    ASSERT_FALSE(link);
    const std::string sentence = to_sentence(link.error());
    if (link.error().code == Errc::link_not_found)
        EXPECT_TRUE(sentence.starts_with("there is no CAN interface 'nothing0'")) << sentence;
    else // a kernel without CAN
        EXPECT_TRUE(sentence.starts_with("this kernel has no CAN: try 'modprobe can-raw'")) << sentence;
}

TEST(Links, RefuseIdentifiersThatAreNone)
{
    EXPECT_EQ(refusal(Links::system(), "can:can0?ids=141-1000"),
              "option ids takes identifiers in hex from 0 to 7FF, such as ids=141-160,280; '141-1000' is none");
}

TEST(Links, RefuseACanRateWithoutACode)
{
    EXPECT_EQ(refusal(Links::system(), "slcan:/dev/ttyACM0?bitrate=333000"),
              "option bitrate must be one of 10000, 20000, 50000, 100000, 125000, 250000, 500000, 800000, 1000000, "
              "not 333000");
}

TEST(Links, TakeFurtherKinds)
{
    struct Wire final : ByteSink {
        void on_write(std::span<const std::uint8_t>, std::uint32_t) override {}
    } wire;
    Links links = Links::system();
    const std::size_t before = links.schemes().size();
    links.add({.name = "sim", .form = "sim:FILE#BUS", .says = "", .open = [&](const Uri& uri, Clock& clock) {
                   EXPECT_EQ(uri.fragment, "left");
                   return std::expected<AnyLink, Error>{std::make_unique<VirtualByteLink>(clock, wire, 9600)};
               }});
    EXPECT_EQ(links.schemes().size(), before + 1);
    RealClock clock;
    EXPECT_TRUE(links.open("sim:arm.toml#left", clock));
    EXPECT_EQ(refusal(links, "sim:arm.toml?x=1"), "sim: has no options, so 'x' means nothing");
}

} // namespace
} // namespace sinew::link
