#include "bench/lateness_bench.hpp"

#include "sinew/link/links.hpp"
#include "sinew/sim/real_time.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>
#include <thread>
#include <vector>

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

constexpr Duration period = 2ms;
constexpr Duration patience = 1s;

/// One joint with its link and the question that it is asked.
struct Asked {
    link::AnyLink* link = nullptr;
    wire::Request request;
    std::uint32_t bit_rate = 0;
};

/// Bits both ways and the response time: what a wire with nothing else on it takes. `answer`: as it came.
Duration ideal(const Asked& asked, const wire::Frame& answer)
{
    const auto bits = [&](const wire::Frame& frame) -> std::int64_t {
        if (std::holds_alternative<std::unique_ptr<link::CanLink>>(*asked.link))
            return sim::can_frame_bits(frame);
        return sim::bits_per_byte * frame.size;
    };
    return bit_time(bits(asked.request.frame), asked.bit_rate) + asked.request.response_time +
           bit_time(bits(answer), asked.bit_rate);
}

/// Puts all that is there behind what `into` holds already.
void read(link::AnyLink& from, wire::Frame& into)
{
    if (auto* can = std::get_if<std::unique_ptr<link::CanLink>>(&from)) {
        (void)(*can)->read({&into, 1});
        return;
    }
    const auto room = std::span(into.data).subspan(into.size);
    if (const auto arrival = std::get<std::unique_ptr<link::ByteLink>>(from)->read(room))
        into.size = static_cast<std::uint8_t>(into.size + arrival->count);
}

bool write(link::AnyLink& to, const wire::Frame& frame)
{
    if (auto* can = std::get_if<std::unique_ptr<link::CanLink>>(&to))
        return (*can)->write({&frame, 1}).value_or(0) == 1;
    return std::get<std::unique_ptr<link::ByteLink>>(to)->write(frame.bytes()).value_or(0) == frame.size;
}

int handle(const link::AnyLink& link)
{
    return std::visit([](const auto& open) { return open->handle(); }, link);
}

/// How much later than it ought to an answer came; nothing: not at all.
std::optional<Duration> ask(Asked& asked, link::Clock& clock)
{
    const link::Handle ready{handle(*asked.link)};
    wire::Frame stale, answer;
    TimePoint sent = clock.now();
    for (const TimePoint gives_up = sent + patience; !write(*asked.link, asked.request.frame); sent = clock.now()) {
        if (sent >= gives_up)
            return {};
        clock.wait({&ready, 1}, gives_up); // an SLCAN link that is just open has to hear its adapter first
        read(*asked.link, stale);
    }
    while (answer.size < asked.request.message->reply.size) {
        clock.wait({&ready, 1}, sent + patience);
        if (clock.now() >= sent + patience)
            return {};
        read(*asked.link, answer);
    }
    return clock.now() - sent - ideal(asked, answer);
}

Duration wait_only(Duration time, link::Clock& clock)
{
    const TimePoint deadline = clock.now() + time;
    while (clock.now() < deadline)
        clock.wait({}, deadline);
    return clock.now() - deadline;
}

Lateness summary(std::vector<Duration>& all)
{
    if (all.empty())
        return {};
    std::ranges::sort(all);
    const auto at = [&](double part) {
        return 1e6 * seconds(all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))]);
    };
    return {.median_us = at(0.5), .p99_us = at(0.99), .most_us = at(1.0)};
}

} // namespace

std::expected<LatenessResult, Error> measure_lateness(const std::string& robot_file, std::size_t answers)
{
    const auto file = config::read_robot_file(robot_file);
    if (!file)
        return std::unexpected(file.error());
    const auto robot = resolve(*file);
    if (!robot)
        return std::unexpected(robot.error());
    link::RealClock clock;
    auto simulator = sim::RealTimeSimulator::make(*file, clock);
    if (!simulator)
        return std::unexpected(simulator.error());
    std::map<std::string, link::AnyLink> links;
    for (const auto& bus : (*simulator)->links()) {
        auto link = link::Links::system().open(bus.uri, clock);
        if (!link)
            return std::unexpected(link.error());
        links.emplace(bus.bus, std::move(*link));
    }
    std::vector<Asked> joints;
    for (const ResolvedJoint& joint : robot->joints) {
        auto request = joint.family->protocol->probe(id_of(joint.device));
        if (!request)
            return std::unexpected(request.error());
        request->response_time = joint.family->response_time.typical; // as simulated devices are delivered
        const auto bit_rate = joint.bus->bit_rate ? static_cast<std::uint32_t>(joint.bus->bit_rate->value)
                                                  : joint.family->default_bit_rate;
        joints.push_back({&links.at(joint.bus->name), *request, bit_rate});
    }

    std::atomic<bool> stop = false;
    std::jthread runner([&] { (*simulator)->run(stop); });
    LatenessResult out{.actuators = joints.size()};
    std::vector<Duration> late, timer, timer_again;
    TimePoint next = clock.now() + 100ms;
    for (std::size_t i = 0; i < answers; ++i) {
        clock.wait({}, next);
        next = std::max(next, clock.now()) + period; // after a missing answer there is nothing to make up for
        Asked& asked = joints[i % joints.size()];
        const Duration time = ideal(asked, {.size = asked.request.message->reply.size});
        if (const auto by = ask(asked, clock))
            late.push_back(*by);
        else
            ++out.missing;
        timer.push_back(wait_only(time, clock));
        timer_again.push_back(wait_only(time, clock));
    }
    stop = true;
    runner.join();
    out.answers = late.size();
    out.held_up = (*simulator)->late();
    out.answer = summary(late);
    out.timer = summary(timer);
    out.timer_again = summary(timer_again);
    return out;
}

} // namespace sinew::bench
