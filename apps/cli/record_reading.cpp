#include "apps/cli/record_reading.hpp"

#include "apps/cli/bus_target.hpp"
#include "apps/cli/device_settings.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/new_file.hpp"
#include "apps/cli/presence.hpp"
#include "apps/cli/readings.hpp"
#include "apps/cli/recorded_robot.hpp"
#include "sinew/record/recorder.hpp"
#include "sinew/record/tap.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using record::Recorder;

constexpr Duration full_period = std::chrono::seconds(1); // of what changes slowly
constexpr Duration lost_period = std::chrono::milliseconds(100);

struct Recorded {
    Driven driven;
    Recorder::Joint id{};
    bool silent = false;
};

/// One bus with its devices and the exchange that runs on it.
struct Line {
    bus::Bus* bus = nullptr;
    std::vector<Recorded> joints{};
    std::vector<wire::Request> requests{};
    std::vector<std::size_t> whose{}; ///< the joint of each request
    std::vector<bus::Result> results{};
    TimePoint next{}, next_full{};
    bool running = false, lost = false;
    std::uint64_t replayed = 0; ///< by recordings, when its last look ended
    bool over = false;          ///< it is that of a recording, which had nothing more to tell
};

/// In the units of the joint.
actuator::State joint_state(const Recorded& one)
{
    auto state = one.driven.state;
    const auto* joint = one.driven.device.joint;
    if (state.position_rad)
        state.position_rad = {to_joint_position(joint, *state.position_rad), state.position_rad.at()};
    if (state.velocity_rad_s)
        state.velocity_rad_s = {to_joint_velocity(joint, *state.velocity_rad_s), state.velocity_rad_s.at()};
    return state;
}

/// What a device is and how it is set, once: so that it can be asked of the recording too. What is not answered is
/// recorded as that; only who answers nothing is not asked on.
void ask_about(const Driven& driven)
{
    const auto& device = driven.device;
    std::vector<wire::Request> all;
    const auto add = [&](const std::expected<wire::Request, Error>& one) {
        const auto is_same = [&](const wire::Request& other) {
            return one->frame.can_id == other.frame.can_id &&
                   std::ranges::equal(one->frame.bytes(), other.frame.bytes());
        };
        if (one && std::ranges::none_of(all, is_same))
            all.push_back(*one);
    };
    add(probe(device, device.id));
    for (const auto& setting : settings_of(device))
        add(request(device, *setting.read, read_values(setting, device.options())));
    if (const auto reads = all_reads(device))
        for (const auto& one : *reads)
            add(one);
    for (std::size_t i = 0; i < all.size() && !interrupted(); ++i)
        if (const auto said = ask(*driven.bus, all[i]); !said && (i == 0 || !may_pass(said.error().code)))
            return;
}

class Recording
{
public:
    Recording(Session& session, Recorder& recorder, Duration period)
        : session_(session), recorder_(recorder), period_(period)
    {
    }

    std::expected<void, Error> add(Driven driven);
    std::expected<void, Error> run(TimePoint end);
    std::uint64_t looks() const { return looks_; }
    std::uint64_t losses() const { return losses_; }
    void ask_what_stays() const;
    std::size_t joints() const
    {
        std::size_t out = 0;
        for (const auto& line : lines_)
            out += line.joints.size();
        return out;
    }

private:
    std::expected<void, Error> start(Line& line, TimePoint now);
    void end(Line& line, TimePoint now);
    std::expected<void, Error> work(Line& line);
    Line& line_of(bus::Bus& bus, const Device& device);

    Session& session_;
    Recorder& recorder_;
    Duration period_; ///< 0: as often as the wire allows
    std::vector<Line> lines_;
    std::uint64_t looks_ = 0, losses_ = 0;
};

Line& Recording::line_of(bus::Bus& bus, const Device& device)
{
    const auto known = std::ranges::find(lines_, &bus, &Line::bus);
    if (known != lines_.end())
        return *known;
    const auto name = device.joint != nullptr ? device.joint->bus.value : short_name(device.link);
    const auto id = recorder_.add_bus({.name = name,
                                       .family = std::string(device.family->name),
                                       .can = device.family->can,
                                       .bit_rate = bus.link_state().bit_rate});
    bus.set_tap([this, id](const bus::Tapped& tapped) { recorder_.frame(id, tapped); });
    return lines_.emplace_back(Line{.bus = &bus});
}

std::expected<void, Error> Recording::add(Driven driven)
{
    Line& line = line_of(*driven.bus, driven.device);
    const auto& known = driven.device;
    const auto id =
        recorder_.add_joint({.name = known.name,
                             .bus = known.joint != nullptr ? known.joint->bus.value : short_name(known.link),
                             .family = std::string(known.family->name),
                             .model = std::string(known.model()),
                             .id = known.id});
    line.joints.push_back({.driven = std::move(driven), .id = id});
    return {};
}

void Recording::ask_what_stays() const
{
    for (const auto& line : lines_)
        for (const auto& one : line.joints)
            ask_about(one.driven);
}

std::expected<void, Error> Recording::start(Line& line, TimePoint now)
{
    const bool full = now >= line.next_full;
    if (full)
        line.next_full = now + full_period;
    line.requests.clear();
    line.whose.clear();
    for (std::size_t i = 0; i < line.joints.size(); ++i) {
        const auto planned =
            line.joints[i].driven.driver->plan_read(full ? actuator::Depth::full : actuator::Depth::motion);
        if (!planned)
            return std::unexpected(planned.error());
        for (const auto& request : planned->all()) {
            line.requests.push_back(request);
            line.whose.push_back(i);
        }
    }
    line.results.assign(line.requests.size(), {});
    line.bus->start(line.requests, line.results);
    line.running = true;
    return {};
}

void Recording::end(Line& line, TimePoint now)
{
    line.running = false;
    ++looks_;
    line.over =
        std::exchange(line.replayed, session_.replayed()) == line.replayed && record::is_replay(line.bus->name());
    std::vector<bool> heard(line.joints.size());
    for (std::size_t i = 0; i < line.results.size(); ++i) {
        Recorded& one = line.joints[line.whose[i]];
        const auto reply = line.results[i].reply();
        const bool good =
            reply && one.driven.driver->absorb(line.requests[i], *reply, line.results[i].at, one.driven.state);
        if (good)
            heard[line.whose[i]] = true;
        else if (reply || reply.error().code != Errc::stopped)
            ++losses_;
    }
    const bool lost = line.bus->link_trouble() != nullptr;
    if (lost != line.lost)
        recorder_.event(now, lost ? Recorder::Level::error : Recorder::Level::info, lost ? "link-lost" : "link-back",
                        line.bus->name());
    line.lost = lost;
    for (std::size_t i = 0; i < line.joints.size() && !interrupted(); ++i) {
        Recorded& one = line.joints[i];
        if (heard[i])
            recorder_.state(one.id, joint_state(one));
        if (heard[i] == one.silent && !lost)
            recorder_.event(now, one.silent ? Recorder::Level::info : Recorder::Level::warning,
                            one.silent ? "answers-again" : "no-answer", one.driven.device.name);
        one.silent = !heard[i];
    }
    line.next = lost ? now + lost_period : std::max(line.next + period_, now);
}

/// Moves on as far as it goes without waiting.
std::expected<void, Error> Recording::work(Line& line)
{
    const TimePoint now = session_.clock().now();
    if (line.running && line.bus->work())
        end(line, now);
    if (!line.running && now >= line.next) {
        if (auto started = start(line, now); !started)
            return started;
        if (line.bus->work())
            end(line, now);
    }
    return {};
}

std::expected<void, Error> Recording::run(TimePoint end)
{
    std::vector<link::Handle> handles;
    for (auto& line : lines_)
        line.next = session_.clock().now();
    while (!interrupted() && session_.clock().now() < end && !std::ranges::all_of(lines_, &Line::over)) {
        TimePoint deadline = end;
        handles.clear();
        for (auto& line : lines_) {
            if (auto worked = work(line); !worked)
                return worked;
            deadline = std::min(deadline, line.running ? line.bus->deadline() : line.next);
            std::ranges::copy(line.bus->handles(), std::back_inserter(handles));
        }
        // In real time a thread of the recorder's own does it.
        constexpr double half = 0.5;
        if (session_.in_virtual_time() && recorder_.fill() > half)
            if (auto drained = recorder_.drain(); !drained)
                return drained;
        if (recorder_.failed())
            return {}; // `finish` says why
        if (!interrupted())
            session_.clock().wait(handles, deadline);
    }
    return {};
}

std::expected<std::vector<Device>, Error> devices_from(const Words& words)
{
    if (!words.has("TARGET"))
        return whole_robot(words);
    auto one = target(words);
    if (!one)
        return std::unexpected(one.error());
    std::vector<Device> out;
    out.push_back(std::move(*one));
    return out;
}

/// Opens and asks all of them before a file is made: where nobody answers an older recording stays as it was. One that
/// is silent among others is recorded as that.
std::expected<std::vector<Driven>, Error> answering(Session& session, const std::vector<Device>& devices)
{
    for (const auto& device : devices)
        if (const auto opened = session.bus_of(device); !opened)
            return std::unexpected(opened.error());
    std::vector<Driven> all;
    std::optional<Error> first;
    bool any = false;
    for (const auto& device : devices) {
        auto driven = drive(session, device);
        if (!driven)
            return std::unexpected(driven.error());
        if (const auto read = read_state(*driven, actuator::Depth::motion); read)
            any = true;
        else if (!may_pass(read.error().code))
            return std::unexpected(read.error());
        else if (!first)
            first = read.error();
        all.push_back(std::move(*driven));
    }
    if (!any && first)
        return std::unexpected(*first);
    return all;
}

void print_summary(const Words& words, const std::string& path, const Recorder& recorder, const Recording& recording,
                   Duration time)
{
    if (words.json())
        print(Json::object({{"file", path},
                            {"messages", static_cast<std::int64_t>(recorder.messages())},
                            {"dropped", static_cast<std::int64_t>(recorder.dropped())},
                            {"joints", static_cast<std::int64_t>(recording.joints())},
                            {"looks", static_cast<std::int64_t>(recording.looks())},
                            {"losses", static_cast<std::int64_t>(recording.losses())},
                            {"time_s", seconds(time)}}));
    else
        fmt::print("{} messages of {} {} in {:.3f} s are in {}\n", recorder.messages(), recording.joints(),
                   recording.joints() == 1 ? "joint" : "joints", seconds(time), path);
    if (recorder.dropped() != 0)
        fmt::print(stderr, "sinew: {} messages were lost because the disk was too slow\n", recorder.dropped());
    if (recording.losses() != 0)
        fmt::print(stderr, "sinew: {} requests were not answered\n", recording.losses());
}

} // namespace

Outcome record_reading(const Words& words, const std::string& path, std::optional<Duration> time)
{
    const auto period = words.period("--rate");
    if (!period)
        return std::unexpected(period.error());
    auto devices = devices_from(words);
    if (!devices)
        return std::unexpected(devices.error());
    std::expected<std::string, Error> robot;
    if (const auto& file = devices->front().file) {
        std::error_code none;
        if (std::filesystem::equivalent(path, file->path, none))
            return fail(Errc::bad_argument, fmt::format("{} is what is read; name another file to record into", path));
        robot = robot_text_at(file->path);
        if (!robot)
            return std::unexpected(robot.error());
    }
    if (auto writable = check_writable(path); !writable)
        return std::unexpected(writable.error());
    Session session;
    auto all = answering(session, *devices);
    if (!all)
        return std::unexpected(all.error());
    const auto zero = session.in_virtual_time() ? record::Time{} : record::time_of_day_zero(session.clock());
    auto recorder = Recorder::create(path, {.zero = zero});
    if (!recorder)
        return std::unexpected(recorder.error());
    if (!robot->empty())
        if (auto kept =
                (*recorder)->attach(std::string(record::robot_attachment), "application/toml", std::move(*robot));
            !kept)
            return std::unexpected(kept.error());
    Recording recording(session, **recorder, period->value_or(Duration{}));
    for (auto& driven : *all)
        if (auto added = recording.add(std::move(driven)); !added)
            return std::unexpected(added.error());
    if (!session.in_virtual_time())
        (*recorder)->run_in_thread();
    recording.ask_what_stays();
    const TimePoint begin = session.clock().now();
    const auto ran = recording.run(time ? begin + *time : TimePoint::max());
    const auto finished = (*recorder)->finish();
    if (!ran || !finished)
        return std::unexpected(ran ? finished.error() : ran.error());
    print_summary(words, path, **recorder, recording, session.clock().now() - begin);
    return exit_done;
}

} // namespace sinew::cli
