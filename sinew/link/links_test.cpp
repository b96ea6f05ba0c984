#include "sinew/link/links.hpp"

#include "sinew/link/link_test_support.hpp"
#include "sinew/link/pty.hpp"
#include "sinew/link/virtual.hpp"

#include <filesystem>
#include <fstream>

namespace sinew::link {
namespace {

namespace fs = std::filesystem;

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

/// A /dev/serial/by-id and a /sys of one adapter with a serial number, whose device file is a pseudo terminal.
class Replugged : public ::testing::Test
{
protected:
    void SetUp() override
    {
        std::string name = (fs::temp_directory_path() / "sinew-links-XXXXXX").string();
        ASSERT_NE(::mkdtemp(name.data()), nullptr);
        root_ = name;
        fs::create_directories(root_ / "dev/serial/by-id");
        plug();
        links_ = Links::system({.dev = (root_ / "dev").string(), .sys = (root_ / "sys").string()});
    }
    ~Replugged() override { fs::remove_all(root_); }

    /// Another device file, to which the name that stays leads.
    void plug()
    {
        port_ = std::move(*PtyMaster::open(9600, clock_));
        const fs::path device = port_->device();
        fs::remove(by_id());
        fs::create_symlink(device, by_id());
        const fs::path usb = root_ / "sys/class/tty" / device.filename();
        fs::create_directories(usb / "device");
        std::ofstream{usb / "idProduct"} << "6001\n";
        std::ofstream{usb / "serial"} << serial_number_ << '\n';
    }
    fs::path by_id() const { return root_ / "dev/serial/by-id/usb-FTDI_A50285BI-if00-port0"; }
    bool opens(const Reopen& reopen)
    {
        const auto link = reopen();
        error_ = link ? "" : to_sentence(link.error());
        return link && port_->client_bit_rate() == 250000U;
    }

    RealClock clock_;
    fs::path root_;
    std::string serial_number_ = "A50285BI";
    std::unique_ptr<PtyMaster> port_;
    Links links_;
    std::string error_;
};

TEST_F(Replugged, IsFoundUnderAnotherNameByItsSerialNumber)
{
    const auto before = std::move(port_);
    plug();
    const std::string old = before->device();
    fs::remove(by_id());
    fs::create_symlink(old, by_id());
    const auto reopen = links_.reopener("serial:" + old + "?baud=250000", clock_);
    fs::remove(by_id());
    EXPECT_FALSE(opens(reopen)) << "another adapter that has got the old name is not taken";
    EXPECT_NE(error_.find("there is no device " + by_id().string()), std::string::npos) << error_;
    plug();
    EXPECT_TRUE(opens(reopen)) << error_;
}

TEST_F(Replugged, IsFollowedThroughTheSymlinkThatNamesIt)
{
    const auto reopen = links_.reopener("serial:" + by_id().string() + "?baud=250000", clock_);
    EXPECT_TRUE(opens(reopen)) << error_;
    port_.reset();
    EXPECT_FALSE(opens(reopen));
    plug();
    EXPECT_TRUE(opens(reopen)) << error_;
}

TEST_F(Replugged, IsKnownByItsDeviceFileOnlyWhereItHasNoSerialNumber)
{
    serial_number_ = "";
    plug();
    const auto reopen = links_.reopener("serial:" + port_->device() + "?baud=250000", clock_);
    fs::remove(by_id());
    EXPECT_TRUE(opens(reopen)) << error_;
}

TEST(Links, SayTheSameOfABadUriWhenReopening)
{
    RealClock clock;
    const auto links = Links::system();
    EXPECT_EQ(to_sentence(links.reopener("serail:/dev/ttyUSB0", clock)().error()),
              refusal(links, "serail:/dev/ttyUSB0"));
    EXPECT_EQ(links.reopener("tcp://nowhere", clock)().error().code, Errc::bad_uri);
}

} // namespace
} // namespace sinew::link
