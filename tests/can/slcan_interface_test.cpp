#include "tests/can/can_test_support.hpp"

#include "sinew/link/pty.hpp"
#include "sinew/link/slcan_codec.hpp"

#include <fcntl.h>
#include <linux/tty.h>
#include <sys/ioctl.h>
#include <thread>

namespace sinew::link::test {
namespace {

/// The kernel's slcan driver on a pseudo terminal whose other end is read in a thread, or not: an interface with a bit
/// rate, a state and a queue, and a bus that can be stopped.
class KernelSlcan
{
public:
    KernelSlcan() : pty_(std::move(*PtyMaster::open(115'200, clock_)))
    {
        line_ = Fd{::open(pty_->device().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
        const int discipline = N_SLCAN;
        EXPECT_EQ(::ioctl(line_.get(), TIOCSETD, &discipline), 0);
        std::array<char, 16> name{};
        EXPECT_EQ(::ioctl(line_.get(), SIOCGIFNAME, name.data()), 0);
        name_ = name.data();
        reading_ = std::thread([this] { run(); });
    }
    ~KernelSlcan()
    {
        end_ = true;
        is_held_ = false;
        reading_.join();
    }

    const std::string& name() const { return name_; }
    void hold() { is_held_ = true; }
    void let_go() { is_held_ = false; }
    std::size_t frames() const { return frames_; } ///< that have gone through

private:
    void run()
    {
        slcan::Reader reader;
        while (!end_) {
            const Handle handles[] = {{.fd = is_held_ ? -1 : pty_->handle()}};
            clock_.wait(handles, clock_.now() + 1ms);
            std::array<std::uint8_t, 256> in;
            const auto arrival = is_held_ ? Arrival{} : pty_->read(in).value_or(Arrival{});
            for (const std::uint8_t byte : std::span(in).first(arrival.count))
                if (reader.take(byte) == slcan::Reader::End::line &&
                    slcan::decode(reader.text()).kind == slcan::Kind::frame)
                    ++frames_;
        }
    }

    RealClock clock_;
    std::unique_ptr<PtyMaster> pty_;
    Fd line_;
    std::string name_;
    std::atomic<bool> end_ = false, is_held_ = false;
    std::atomic<std::size_t> frames_ = 0;
    std::thread reading_;
};

struct SlcanInterface : testing::Test {
    /// Writes one frame after the other until the link takes no more; how many it took.
    std::size_t fill(SocketCanLink& link, std::uint32_t id)
    {
        std::size_t taken = 0;
        for (;;) {
            const auto count = link.write({{frame(id, static_cast<std::uint8_t>(taken))}});
            EXPECT_TRUE(count) << to_sentence(count.error());
            if (!count || *count == 0 || taken == 100'000)
                return taken;
            taken += *count;
        }
    }
    /// Fills until the link takes nothing for 20 ms: until nothing between here and the adapter moves any more.
    std::size_t fill_to_the_brim(SocketCanLink& link, std::uint32_t id)
    {
        std::size_t taken = 0;
        for (TimePoint quiet_since = clock.now(); clock.now() < quiet_since + 20ms;) {
            const std::size_t count = fill(link, id);
            taken += count;
            if (count != 0)
                quiet_since = clock.now();
            else
                clock.wait({}, clock.now() + 1ms);
        }
        return taken;
    }

    /// Frames of the other programs are heard; those with the own identifier would be confirmations.
    static void expect_no_confirmation(SocketCanLink& link)
    {
        wire::Frame heard;
        while (link.read({&heard, 1})->count != 0)
            EXPECT_NE(heard.can_id, 0x142u) << "a confirmation came out as a reply";
    }

    RealClock clock;
    KernelSlcan adapter;
};

TEST_F(SlcanInterface, NeedsABitRateAndTellsIt)
{
    const auto down = can_interface(adapter.name());
    ASSERT_TRUE(down);
    EXPECT_FALSE(down->is_up);
    const auto refused = SocketCanLink::open({.interface = adapter.name()}, clock);
    ASSERT_FALSE(refused);
    EXPECT_EQ(to_sentence(refused.error()), adapter.name() + " is down: 'ip link set " + adapter.name() +
                                                " up type can bitrate 1000000' brings it up");
    shell("ip link set " + adapter.name() + " up type can bitrate 1000000");
    const auto up = can_interface(adapter.name());
    ASSERT_TRUE(up);
    EXPECT_TRUE(up->is_up);
    EXPECT_EQ(up->bit_rate, 1'000'000u);
    EXPECT_EQ(up->tx_queue, 10u);
    EXPECT_EQ(up->state, CanState::error_active);
    EXPECT_EQ(open({.interface = adapter.name()}, clock)->state().bit_rate, 1'000'000u);
    const auto other = SocketCanLink::open({.interface = adapter.name(), .stated_bit_rate = 500'000}, clock);
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().code, Errc::link_failed);
    EXPECT_TRUE(to_sentence(other.error()).starts_with(adapter.name() + " runs at 1000000 bit/s, not at 500000"));
}

TEST_F(SlcanInterface, ABusThatStandsStillTakesFewFramesOfOneProgramAndLosesNone)
{
    shell("ip link set " + adapter.name() + " up type can bitrate 1000000");
    const auto link = open({.interface = adapter.name()}, clock);
    adapter.hold();
    const std::size_t taken = fill_to_the_brim(*link, 0x141);
    EXPECT_EQ(link->counters().queue_full, 0u) << "it fills the queue of the interface against others";
    const TimePoint before = clock.now();
    const Handle room[] = {{.fd = link->handle(), .wants_write = true}};
    clock.wait(room, before + 20ms);
    EXPECT_GE(clock.now(), before + 20ms) << "the descriptor tells of room where there is none";

    adapter.let_go();
    clock.wait(room, clock.now() + patience);
    EXPECT_LT(clock.now(), before + patience) << "the descriptor does not tell of room";
    for (const TimePoint end = clock.now() + patience; adapter.frames() < taken && clock.now() < end;)
        clock.wait({}, clock.now() + 1ms);
    EXPECT_EQ(adapter.frames(), taken);
}

TEST_F(SlcanInterface, AQueueThatOthersHaveFilledIsWaitedForAndLosesNothing)
{
    shell("ip link set " + adapter.name() + " up type can bitrate 1000000");
    const auto link = open({.interface = adapter.name()}, clock);
    const auto second = open({.interface = adapter.name()}, clock);
    adapter.hold();
    const std::size_t first = fill_to_the_brim(*link, 0x141);
    const std::size_t own = fill_to_the_brim(*second, 0x142);
    ASSERT_GT(own, 0u) << "without frames of ours in the queue nothing is confirmed";
    EXPECT_GT(second->counters().queue_full, 0u);
    const std::size_t taken = first + own;

    const auto refusals = second->counters().queue_full;
    ASSERT_EQ(*second->write({{frame(0x142)}}), 0u);
    EXPECT_LE(second->counters().queue_full, refusals + 1) << "it asks the kernel before anything can have changed";
    const TimePoint before = clock.now();
    int looks = 0;
    for (; clock.now() < before + 50ms; ++looks) {
        expect_no_confirmation(*second);
        EXPECT_EQ(*second->write({{frame(0x142)}}), 0u);
        const Handle room[] = {{.fd = second->handle(), .wants_write = true}};
        clock.wait(room, before + 50ms);
    }
    EXPECT_LT(looks, 200) << "it spins while the queue is full";

    adapter.let_go();
    const TimePoint end = clock.now() + patience;
    std::size_t last = 0;
    while (last == 0 && clock.now() < end) {
        expect_no_confirmation(*second);
        last = *second->write({{frame(0x142)}});
        const Handle handles[] = {{.fd = second->handle()}};
        if (last == 0)
            clock.wait(handles, end);
    }
    EXPECT_EQ(last, 1u);
    while (adapter.frames() < taken + 1 && clock.now() < end)
        clock.wait({}, clock.now() + 1ms);
    EXPECT_EQ(adapter.frames(), taken + 1);
    expect_no_confirmation(*second);
}

} // namespace
} // namespace sinew::link::test
