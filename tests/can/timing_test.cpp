#include "tests/can/can_test_support.hpp"

#include "sinew/bus/bus.hpp"
#include "sinew/family/nuri/framing.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/family/sam/framing.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/link/links.hpp"
#include "sinew/link/pty.hpp"

#include <algorithm>
#include <atomic>
#include <fmt/format.h>
#include <functional>
#include <initializer_list>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

/// How late things are, on the kernel's CAN stack and terminals in the virtual time of a guest: its clock counts
/// instructions, so that what is asserted here does not depend on the load of the host. Elsewhere these figures mean
/// nothing.
namespace sinew::link::test {
namespace {

constexpr int bus_count = 4;
constexpr int actuators = 8;

std::string interface_of(int bus)
{
    return fmt::format("vcan{}", bus + 10);
}

/// Of one priority, so that neither side interrupts the other amid a batch.
void become_real_time()
{
    const sched_param priority{.sched_priority = 80};
    ASSERT_EQ(sched_setscheduler(0, SCHED_FIFO, &priority), 0);
    ASSERT_EQ(mlockall(MCL_CURRENT | MCL_FUTURE), 0);
}

/// All actuators of all buses as a process of its own: sends every frame back as it came, which is what an RMD does
/// with many of them.
class Answering
{
public:
    Answering()
    {
        std::array<int, 2> ready{};
        EXPECT_EQ(pipe(ready.data()), 0);
        process_ = fork();
        if (process_ == 0)
            run(ready[1]);
        char byte = 0;
        EXPECT_EQ(::read(ready[0], &byte, 1), 1);
        close(ready[0]);
        close(ready[1]);
    }
    ~Answering()
    {
        kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
    }

private:
    [[noreturn]] static void run(int ready)
    {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        become_real_time();
        RealClock clock;
        std::array<std::unique_ptr<SocketCanLink>, bus_count> links;
        std::array<pollfd, bus_count> handles{};
        for (int bus = 0; bus < bus_count; ++bus) {
            links[bus] = open({.interface = interface_of(bus)}, clock);
            handles[bus] = {.fd = links[bus]->handle(), .events = POLLIN, .revents = 0};
        }
        if (::write(ready, "r", 1) != 1)
            _exit(1);
        for (;;) {
            ::poll(handles.data(), handles.size(), -1);
            for (auto& link : links) {
                std::array<wire::Frame, 2 * actuators> batch;
                std::size_t count = 0;
                while (count < batch.size() && link->read(std::span(batch).subspan(count)).value().count != 0)
                    ++count;
                for (std::size_t sent = 0; sent < count;)
                    sent += link->write(std::span(batch).first(count).subspan(sent)).value();
            }
        }
    }

    pid_t process_ = -1;
};

struct Timing : testing::Test {
    void SetUp() override
    {
        for (int bus = 0; bus < bus_count; ++bus)
            shell(fmt::format("ip link add dev {0} type vcan && ip link set {0} up", interface_of(bus)));
        become_real_time();
    }
    void TearDown() override
    {
        for (int bus = 0; bus < bus_count; ++bus)
            shell(fmt::format("ip link del {}", interface_of(bus)));
    }
    std::unique_ptr<bus::Bus> open_bus(int number, bus::Settings settings = {})
    {
        auto link = test::open({.interface = interface_of(number), .stated_bit_rate = 1'000'000}, clock);
        return std::make_unique<bus::Bus>(interface_of(number), std::unique_ptr<CanLink>(std::move(link)), clock,
                                          rmd::protocol(), settings);
    }
    static std::vector<wire::Request> requests()
    {
        std::vector<wire::Request> all;
        for (int id = 1; id <= actuators; ++id)
            all.push_back(*wire::make_request(id, rmd::ReadStatus2{}));
        return all;
    }

    RealClock clock;
};

TEST_F(Timing, ACallWithoutAnswerReturnsWithinAMillisecondOfItsDeadline)
{
    const auto bus = open_bus(0);
    const auto asked = requests();
    Duration latest{};
    for (std::size_t count : {std::size_t{1}, asked.size()})
        for (int i = 0; i < 50; ++i) {
            std::vector<bus::Result> results(count);
            ASSERT_TRUE(bus->exchange(std::span(asked).first(count), results));
            const TimePoint now = clock.now();
            TimePoint deadline{};
            for (const auto& result : results) {
                ASSERT_FALSE(result.good);
                EXPECT_EQ(result.error.code, Errc::timeout);
                deadline = std::max(deadline, result.deadline);
            }
            ASSERT_GE(now, deadline) << "it gave up too early";
            latest = std::max(latest, now - deadline);
        }
    fmt::print("100 calls without an answer returned at most {:.0f} us after their deadline\n", seconds(latest) * 1e6);
    EXPECT_LE(latest, 1ms);
}

TEST_F(Timing, AWaitingCallEndsAsSoonAsItsInterfaceGoesDown)
{
    const auto bus = open_bus(0);
    const auto slow = wire::make_request(1, rmd::ReadStatus2{}, {}, 10s); // a device that may take so long
    std::atomic<TimePoint> down_at{};
    std::thread taking_down([&] {
        clock.wait({}, clock.now() + 20ms);
        set_up("vcan10", false); // to load a program would be idle time, which this clock jumps over
        down_at = clock.now();
    });
    bus::Result result;
    const TimePoint begin = clock.now();
    const auto done = bus->exchange({&*slow, 1}, {&result, 1});
    const TimePoint ended = clock.now();
    taking_down.join();
    ASSERT_FALSE(result.good);
    EXPECT_EQ(result.error.code, Errc::link_lost);
    EXPECT_EQ(to_sentence(result.error),
              "read-status2 to id 1: vcan10 went down; 'ip link set vcan10 up' brings it up again");
    EXPECT_FALSE(done);
    EXPECT_GE(ended, begin + 20ms);
    EXPECT_LE(ended, down_at.load() + 1ms);
}

/// Servos of a family behind a pseudo terminal, none of which answers.
class Silence
{
public:
    explicit Silence(const wire::Protocol& protocol)
        : protocol_(protocol), port_(std::move(*PtyMaster::open(1'000'000, clock_)))
    {
        become_real_time();
    }
    /// How late a call is, on a line that is not in doubt yet. `tries` go out, and the line is silent for `between`.
    Duration lateness(const wire::Request& asked, std::initializer_list<wire::Request> tries, Duration between)
    {
        bus::Bus bus("silent", *Links::system().open("serial:" + port_->device() + "?baud=1000000", clock_), clock_,
                     protocol_);
        Duration computed = between;
        for (const auto& request : tries)
            computed += predict(bus.conversation().line(), request).total() + bus.conversation().margin();
        bus::Result result;
        const TimePoint start = clock_.now();
        EXPECT_TRUE(bus.exchange({&asked, 1}, {&result, 1}));
        const TimePoint now = clock_.now();
        EXPECT_EQ(result.error.code, Errc::timeout);
        EXPECT_GE(now, start + computed) << "it gave up too early";
        return now - start - computed;
    }

private:
    RealClock clock_;
    const wire::Protocol& protocol_;
    std::unique_ptr<PtyMaster> port_;
};

void expect_in_time(std::string_view family, const std::function<Duration()>& lateness)
{
    Duration latest{};
    for (int i = 0; i < 50; ++i)
        latest = std::max(latest, lateness());
    fmt::print("{}: 50 calls without an answer returned at most {:.0f} us after their deadline\n", family,
               seconds(latest) * 1e6);
    EXPECT_LE(latest, 1ms);
}

TEST(SerialTiming, ANuriCallWithoutAnswerReturnsWithinAMillisecondOfItsDeadline)
{
    Silence servos(nuri::protocol());
    const auto asked = *wire::make_request(1, nuri::RequestPositionFeedback{}, {}, 100us);
    expect_in_time("nuri", [&] { return servos.lateness(asked, {asked, asked}, {}); });
}

/// The time-out puts the line in quarantine, and the probe that ends it has no answer either.
TEST(SerialTiming, ASamCallWithoutAnswerReturnsWithinAMillisecondOfItsDeadline)
{
    Silence servos(sam::protocol());
    const auto asked = *wire::make_request(1, sam::QuickReadStatus{}, {}, 100us);
    auto probe = *sam::protocol().probe(1);
    probe.response_time = asked.response_time;
    expect_in_time("sam", [&] { return servos.lateness(asked, {asked, probe}, bus::Settings{}.late_max); });
}

/// How late each of many ticks of a loop of 1 kHz began; `work(tick)` is done in each.
template <class Work>
std::vector<Duration> lateness_at_1_khz(Clock& clock, int ticks, Work&& work)
{
    std::vector<Duration> late;
    late.reserve(static_cast<std::size_t>(ticks));
    TimePoint tick = clock.now() + 10ms;
    for (int i = 0; i < ticks; ++i, tick += 1ms) {
        while (clock.now() < tick)
            clock.wait({}, tick);
        late.push_back(clock.now() - tick);
        work(tick);
    }
    std::ranges::sort(late);
    return late;
}

Duration quantile(const std::vector<Duration>& sorted, double part)
{
    return sorted[static_cast<std::size_t>(static_cast<double>(sorted.size() - 1) * part)];
}

TEST_F(Timing, FourBusesOfEightActuatorsRunAt1KhzAsEvenlyAsABareLoop)
{
    constexpr int ticks = 5'000;
    const Answering answering;
    std::array<std::unique_ptr<bus::Bus>, bus_count> owned;
    std::array<bus::Bus*, bus_count> buses{};
    std::array<std::array<bus::Result, actuators>, bus_count> results;
    const auto asked = requests();
    for (int i = 0; i < bus_count; ++i) {
        owned[i] = open_bus(i);
        buses[i] = owned[i].get();
    }
    int overruns = 0;
    int unanswered = 0;
    Duration longest{};
    const auto cycle = [&](TimePoint tick) {
        for (int i = 0; i < bus_count; ++i) {
            results[i].fill({});
            buses[i]->start(asked, results[i]);
        }
        drive(buses);
        longest = std::max(longest, clock.now() - tick);
        overruns += clock.now() > tick + 1ms ? 1 : 0;
        for (const auto& bus : results)
            unanswered += static_cast<int>(std::ranges::count(bus, false, &bus::Result::good));
    };
    for (int i = 0; i < 20; ++i)
        cycle(clock.now()); // every page is there, and every bus has measured its margin
    overruns = unanswered = 0;
    longest = {};
    const auto bare = lateness_at_1_khz(clock, ticks, [](TimePoint) {});
    const auto busy = lateness_at_1_khz(clock, ticks, cycle);
    for (const double part : {0.5, 0.99, 0.999, 1.0})
        fmt::print("lateness at {:5.1f} %: bare loop {:6.1f} us, with 4 x 8 actuators {:6.1f} us\n", part * 100,
                   seconds(quantile(bare, part)) * 1e6, seconds(quantile(busy, part)) * 1e6);
    fmt::print("longest cycle {:.0f} us\n", seconds(longest) * 1e6);
    EXPECT_EQ(unanswered, 0);
    EXPECT_EQ(overruns, 0);
    EXPECT_LE(quantile(busy, 0.999), quantile(bare, 0.999) * 12 / 10);
}

} // namespace
} // namespace sinew::link::test
