#include "sinew/robot/core.hpp"

#include "sinew/base/seconds.hpp"
#include "sinew/link/can_ids.hpp"
#include "sinew/robot/guardian.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <set>

namespace sinew::robot {
namespace {

Duration period_of(const config::Bus& bus)
{
    if (!bus.rate_hz)
        return {};
    return from_seconds(1.0 / *bus.rate_hz);
}

bool is_can(const link::AnyLink& link)
{
    return std::holds_alternative<std::unique_ptr<link::CanLink>>(link);
}

/// The identifiers with which the joints of a bus are asked and answer, other programs' questions to them among them;
/// none on serial lines.
std::vector<std::uint32_t> identifiers_of(std::span<const ResolvedJoint> joints, const config::Bus& bus)
{
    std::set<std::uint32_t> out;
    const auto add = [&](std::uint32_t base, int id) {
        if (base != 0)
            out.insert(base + static_cast<std::uint32_t>(id));
    };
    for (const auto& joint : joints) {
        if (joint.bus->name != bus.name)
            continue;
        const int id = id_of(joint.device);
        add(options_of(joint.device).can_reply_base, id);
        for (const auto* message : line_of(joint.device).messages)
            for (const auto* side : {&message->request, &message->reply})
                if (side->exists() && !side->layout->can_fixed)
                    add(side->layout->can_base, id);
    }
    return {out.begin(), out.end()};
}

} // namespace

// ---- opening ----

std::expected<std::unique_ptr<bus::Bus>, Error> Core::open_bus(const config::Bus& bus, const link::Links& links,
                                                               const OpenOptions& options)
{
    const Family& family = *find_family(bus.family.value);
    const auto given = options.links.find(bus.name);
    std::string uri = given != options.links.end() ? given->second
                      : options.simulated          ? fmt::format("sim:{}#{}", file.path, bus.name)
                      : bus.link                   ? bus.link->value
                                                   : std::string{};
    if (uri.empty())
        return config::fail_at(file, bus.at, fmt::format("bus {} needs a link.", bus.name));
    uri = link::with_bit_rate(uri,
                              bus.bit_rate ? static_cast<std::uint32_t>(bus.bit_rate->value) : family.default_bit_rate);
    // Of a busy bus the frames of others need not wake this program.
    const auto own = link::with_can_ids(uri, identifiers_of(resolved.joints, bus));
    auto opened = links.open(own, *clock);
    if (!opened)
        return std::unexpected(std::move(opened.error()));
    if (family.can != is_can(*opened))
        return fail(Errc::bad_argument, fmt::format("{} devices are on {}, which {} is not", family.name,
                                                    family.can ? "CAN" : "serial lines", uri));
    auto made = std::make_unique<bus::Bus>(bus.name, std::move(*opened), *clock, *family.protocol, options.settings);
    made->set_reopen(links.reopener(own, *clock));
    uris_.push_back(std::move(uri));
    return made;
}

std::expected<std::unique_ptr<Core>, Error> Core::make(config::RobotFile file, const link::Links& links,
                                                       link::Clock& clock, const OpenOptions& options)
{
    auto core = std::make_unique<Core>();
    core->file = std::move(file);
    core->clock = &clock;
    core->guardian_ = options.guardian;
    auto resolved = resolve(core->file);
    if (!resolved)
        return std::unexpected(std::move(resolved.error()));
    core->resolved = std::move(*resolved);
    if (core->file.buses.size() > guardian::most_buses)
        return config::fail_at(core->file, core->file.buses[guardian::most_buses].at,
                               fmt::format("a robot has at most {} buses, and this one has {}; drive the others from a "
                                           "second program with a file of its own.",
                                           guardian::most_buses, core->file.buses.size()));
    for (const auto& [name, link] : options.links)
        if (core->file.find_bus(name) == nullptr)
            return fail(Errc::unknown_name, fmt::format("{} has no bus '{}'", core->file.path, name));
    core->joints.reserve(core->resolved.joints.size());
    for (const auto& joint : core->resolved.joints)
        core->joints.emplace_back(joint, core->file, clock, core->incidents);
    for (const auto& bus : core->file.buses) {
        auto opened = core->open_bus(bus, links, options);
        if (!opened)
            return std::unexpected(std::move(opened.error()));
        auto& line = core->lines.emplace_back(
            std::make_unique<Line>(std::move(*opened), period_of(bus), core->file.safety.whole_robot, core->pause));
        std::vector<Joint*> own;
        for (Joint& joint : core->joints)
            if (joint.bus() == bus.name) {
                own.push_back(&joint);
                line->bus().set_device(id_of(joint.device()), {.line = &line_of(joint.device()),
                                                               .options = options_of(joint.device()),
                                                               .response_time = response_time_of(joint.device())});
            }
        line->set_joints(std::move(own));
        core->buses.push_back(&line->bus());
    }
    for (bus::Bus* bus : core->buses) {
        auto others = core->buses;
        std::erase(others, bus);
        bus->stop_when_lost(std::move(others));
    }
    return core;
}

// ---- the cycle ----

void Core::exchange_lines()
{
    show_life();
    for (auto& line : lines)
        line->start();
    drive();
    const TimePoint now = clock->now();
    Duration longest{};
    for (auto& line : lines) {
        line->absorb(now);
        longest = std::max(longest, line->exchange());
    }
    for (auto& line : lines) // each waits for the slowest
        line->note_exchange(longest);
    // A link that was lost when the robot was stopped is back and has sent its stop: from now on it may be read.
    for (auto& line : lines)
        if (!enabled && !stop_asked_.load() && line->bus().link_trouble() == nullptr && !line->bus().has_news())
            line->close_stop();
}

/// Stops all for a reason; what is returned is the reason.
std::unexpected<Error> Core::stop_for(Error why)
{
    const bool is_new = !fault;
    for (const Stopped& one : stop(to_sentence(why)))
        if (one.outcome == Stopped::Outcome::failed)
            incidents.add({clock->now(), std::string(one.joint), one.why.code,
                           fmt::format("{} did not confirm the stop: {}", one.joint, to_sentence(one.why))});
    if (is_new)
        fault = why;
    return std::unexpected(std::move(why));
}

/// One that was asked for while the robot is not enabled. Whoever enables it is told; until then it can be read.
void Core::let_a_stop_out()
{
    if (enabled || !stop_asked_.load())
        return;
    drive();
    for (auto& line : lines)
        if (line->bus().link_trouble() == nullptr)
            line->close_stop();
}

std::expected<void, Error> Core::read_only()
{
    let_a_stop_out();
    for (auto& line : lines)
        line->forget_where_it_held(clock->now());
    tell_owed_stops();
    for (auto& line : lines) {
        line->clear();
        for (Joint* joint : line->joints())
            (void)line->plan_read(*joint, Depth::motion);
    }
    exchange_lines();
    for (auto& line : lines)
        tell_the_guardian(*line);
    if (fault)
        return std::unexpected(*fault);
    return fail(Errc::unsupported, "the robot is not enabled; it was only read");
}

/// After an exchange of a line: whether there is a reason to stop.
std::expected<void, Error> Core::look_at(Line& line)
{
    tell_the_guardian(line);
    if (line.is_lost()) {
        Error why = line.bus().link_trouble() != nullptr ? *line.bus().link_trouble() : Error{.code = Errc::link_lost};
        if (why.detail.empty())
            why.detail = fmt::format("the link of bus {} is lost; is its adapter still plugged in?", line.bus().name());
        incidents.add({clock->now(), {}, why.code, to_sentence(why)});
        return stop_for(std::move(why));
    }
    if (stop_asked_.load())
        return stop_for({.code = Errc::stopped});
    if (auto finding = line.judge(clock->now()); finding.measure != Measure::none) {
        // A program that was kept from running finds its devices silent, and its guardian has stopped them before.
        if (auto fine = heed_the_guardian(); !fine)
            return fine;
        return stop_for(std::move(finding.why));
    }
    return {};
}

/// One that lost its link has stopped the others, which is no fault of theirs.
std::expected<void, Error> Core::look_at_all()
{
    for (auto& line : lines)
        if (line->is_lost())
            return look_at(*line);
    for (auto& line : lines)
        if (auto fine = look_at(*line); !fine)
            return fine;
    return {};
}

/// After a pause of the program.
std::expected<void, Error> Core::look_first()
{
    const TimePoint now = clock->now();
    if (std::ranges::none_of(lines, [&](const auto& line) { return line->must_look_first(now); }))
        return {};
    for (auto& line : lines)
        line->plan_first_look(now);
    exchange_lines();
    return look_at_all();
}

std::expected<void, Error> Core::cycle()
{
    ask_for_real_time();
    if (stop_asked_.load() && enabled)
        return stop_for({.code = Errc::stopped});
    if (auto fine = heed_the_guardian(); !fine)
        return fine;
    if (!enabled)
        return read_only();
    const TimePoint now = clock->now();
    pause.turn(now);
    for (auto& line : lines) // all of them before the first is planned: what is planned counts as told
        if (auto finding = line->begin_cycle(now); finding.measure != Measure::none)
            return stop_for(std::move(finding.why));
    if (auto fine = look_first(); !fine)
        return fine;
    for (auto& line : lines)
        line->plan_cycle(clock->now());
    exchange_lines();
    pause.rest_until(clock->now());
    return look_at_all();
}

std::expected<void, Error> Core::run(Duration period, const std::function<bool()>& each, TimePoint until)
{
    ask_for_real_time();
    TimePoint next = clock->now();
    leaving = false;
    for (auto& line : lines)
        line->begin_run(next);
    for (;;) {
        TimePoint now = clock->now();
        pause.turn(now);
        if (!enabled)
            return fault ? std::expected<void, Error>(std::unexpected(*fault))
                         : fail(Errc::unsupported, "the robot is not enabled");
        if (stop_asked_.load())
            return stop_for({.code = Errc::stopped});
        if (auto fine = heed_the_guardian(); !fine)
            return fine;
        if (now >= until || leaving)
            break;
        if (now >= next) {
            next += period * ((now - next) / period + 1);
            if (!each())
                break;
            now = clock->now();
            pause.turn(now);
            if (!enabled)
                continue;
        }
        TimePoint wake = std::min(next, until);
        std::array<link::Handle, 2 * guardian::most_buses> handles;
        std::size_t count = 0;
        bool ended = false;
        for (auto& line : lines) {
            if (!line->busy() && now >= line->due()) {
                if (!line->has_looked())
                    if (auto finding = line->begin_cycle(now); finding.measure != Measure::none)
                        return stop_for(std::move(finding.why));
                if (line->must_look_first(now)) {
                    line->plan_first_look(now);
                } else {
                    const Duration own = line->period() > Duration{} ? line->period() : period;
                    line->set_due(line->due() + own * ((now - line->due()) / own + 1));
                    line->plan_cycle(now);
                }
                line->start();
            }
            if (line->busy() && line->bus().work()) {
                const TimePoint at = clock->now();
                pause.turn(at);
                line->absorb(at);
                if (auto fine = look_at(*line); !fine)
                    return fine;
                ended = true;
            }
            wake = std::min(wake, line->busy() ? line->bus().deadline() : line->due());
            const auto all = line->bus().handles();
            for (const auto& handle : line->busy() ? all : all.last(1))
                handles[count++] = handle;
        }
        if (!ended) {
            pause.rest_until(wake);
            clock->wait(std::span(handles).first(count), wake);
        }
    }
    if (auto ended = end_exchanges(); !ended)
        return ended;
    for (auto& line : lines)
        if (enabled && line->has_looked()) { // and has not told what it was to tell
            line->plan_cycle(clock->now());
            line->start();
        }
    auto ended = end_exchanges();
    pause.begin(clock->now());
    return ended;
}

std::expected<void, Error> Core::end_exchanges()
{
    drive();
    for (auto& line : lines)
        if (line->busy()) {
            line->absorb(clock->now());
            if (auto fine = look_at(*line); !fine)
                return fine;
        }
    return {};
}

/// Answers without a checksum are believed when they agree, so one exchange may not be enough.
std::expected<void, Error> Core::read(Depth depth)
{
    let_a_stop_out();
    for (auto& line : lines)
        line->forget_where_it_held(clock->now());
    if (!enabled)
        tell_owed_stops();
    const TimePoint begun = clock->now();
    const auto is_old = [&](const Joint& joint) {
        return !joint.raw_.position_rad || joint.raw_.position_rad.at() < begun;
    };
    for (int i = 0; i < most_tries && (i == 0 || std::ranges::any_of(joints, is_old)); ++i) {
        for (auto& line : lines) {
            line->clear();
            for (Joint* joint : line->joints())
                if (i == 0 || is_old(*joint))
                    if (auto planned = line->plan_read(*joint, depth); !planned)
                        return planned;
        }
        exchange_lines();
    }
    for (const Joint& joint : joints)
        if (joint.answered_at_ < begun) {
            Error why = joint.trouble_.value_or(Error{.code = Errc::timeout});
            if (why.code != Errc::stopped)
                why.detail = fmt::format("{} does not answer", joint.name());
            return std::unexpected(std::move(why));
        }
    return {};
}

void Core::request_stop() noexcept
{
    stop_asked_.store(true);
    for (bus::Bus* bus : buses)
        bus->request_stop();
}

} // namespace sinew::robot
