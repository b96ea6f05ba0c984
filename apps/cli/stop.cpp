#include "apps/cli/exit_codes.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/present.hpp"
#include "apps/cli/rest.hpp"
#include "sinew/family/broadcast.hpp"
#include "sinew/link/uri.hpp"
#include "sinew/robot/guardian.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <map>

namespace sinew::cli {
namespace {

struct Told {
    std::string says;       ///< what it does now
    bool confirmed = false; ///< the device said so
};

struct Done {
    std::string name;
    std::expected<Told, Error> outcome;
    bool perhaps = false; ///< of a failure: it was told, and may have obeyed
};

std::expected<Told, Error> stop_driven(Driven& driven, bool keep_torque)
{
    if (keep_torque) {
        const Telling told = tell_to_hold(driven);
        if (!told.confirmed)
            return std::unexpected(told.confirmed.error());
        if (told.rest == Rest::braked)
            return std::unexpected(Error{.code = Errc::timeout,
                                         .id = driven.device.id,
                                         .detail = "it does not say where it is to hold; it was told to brake, and may "
                                                   "not have heard that either"});
        return Told{"told to hold", false};
    }
    const auto requests = driven.driver->plan({.mode = actuator::Mode::release}, {});
    if (!requests)
        return std::unexpected(requests.error());
    const bool acknowledged = requests->all().back().answered;
    if (auto sent = carry_out(driven, *requests); !sent)
        return std::unexpected(sent.error());
    return acknowledged ? Told{"released", true} : Told{"released (not acknowledged)", false};
}

/// Again where a device did not confirm: a stop changes nothing when it is carried out twice, and one lost frame must
/// not leave a motor running.
std::expected<Told, Error> stop_one(Session& session, Device device, bool keep_torque, int attempts = 3)
{
    auto driven = drive(session, std::move(device));
    if (!driven)
        return std::unexpected(driven.error());
    return until_confirmed([&] { return stop_driven(*driven, keep_torque); }, attempts);
}

/// All devices of a line at once, where the family has a message for that.
std::expected<Told, Error> stop_line(Session& session, const Device& everybody)
{
    const auto all = stop_of_all(*everybody.family);
    if (!all)
        return fail(Errc::unsupported,
                    fmt::format("{} has no message that stops all devices of a line", everybody.family->name));
    const auto bus = session.bus_of(everybody);
    if (!bus)
        return std::unexpected(bus.error());
    if (const auto sent = ask(**bus, all->request); !sent)
        return std::unexpected(sent.error());
    return Told{fmt::format("told to {} (not acknowledged)", to_word(all->mode)), false};
}

/// Whether two links lead to the same port, whatever they say of it.
bool is_same_port(const std::string& one, const std::string& other)
{
    const auto a = link::parse_uri(one), b = link::parse_uri(other);
    std::error_code none;
    return a && b && (a->target == b->target || std::filesystem::equivalent(a->target, b->target, none));
}

/// A program with a guardian holds its ports, and would go on commanding: it is told first.
class Programs
{
public:
    Programs() : all_(robot::guarded_programs()) {}

    /// What the program that holds this link did to this device, or with -1 to all of them; nothing where none holds
    /// it, or nobody answers for it.
    std::optional<Done> stop_holder(const std::string& name, const std::string& link, int id)
    {
        for (const auto& program : all_) {
            if (std::ranges::none_of(program.links, [&](const auto& held) { return is_same_port(held, link); }))
                continue;
            if (!told_.contains(program.pid))
                told_.emplace(program.pid, robot::stop_program(program.pid));
            if (const auto& told = told_.at(program.pid); told && answers_for(*told, link, id))
                return done(name, program.pid, *told, link);
        }
        return std::nullopt;
    }

    /// Whether one was told that may not have let go of its port yet.
    bool any_was_told() const { return !told_.empty(); }

private:
    /// A program that moves one device has its id behind the # of its link.
    static bool answers_for(const robot::StoppedProgram& told, const std::string& link, int id)
    {
        return std::ranges::all_of(told.buses, [&](const auto& one) {
            const auto uri = link::parse_uri(one.link);
            return !is_same_port(one.link, link) || !uri || uri->fragment.empty() ||
                   uri->fragment == std::to_string(id);
        });
    }

    static Done done(const std::string& name, int pid, const robot::StoppedProgram& told, const std::string& link)
    {
        using enum robot::StoppedBus::Outcome;
        const auto who =
            fmt::format("{}the program with process id {}", told.by_guardian ? "the guardian of " : "", pid);
        const auto bus =
            std::ranges::find_if(told.buses, [&](const auto& one) { return is_same_port(one.link, link); });
        if (bus == told.buses.end())
            return {name, fail(Errc::timeout, fmt::format("{} says nothing of {}", who, link)), true};
        if (bus->outcome == failed)
            return {name,
                    fail(bus->says.contains("link is lost") ? Errc::link_lost : Errc::timeout,
                         fmt::format("{} was asked to stop {}: {}", who, link, bus->says)),
                    true};
        if (bus->outcome == confirmed)
            return {name, Told{fmt::format("{} stopped its motors", who), true}};
        if (told.by_guardian)
            return {name,
                    fail(Errc::timeout, fmt::format("{} told {} to stop, and no device could be asked whether it did; "
                                                    "end that program and stop again",
                                                    who, link)),
                    true};
        return {name, Told{fmt::format("{} told its motors to stop (not acknowledged)", who), false}};
    }

    std::vector<robot::Guarded> all_;
    std::map<int, std::expected<robot::StoppedProgram, Error>> told_;
};

/// A program that was told to stop its one device ends, and then the port is free for the others.
void wait_for_port(Session& session, const Programs& programs, const std::string& link)
{
    constexpr Duration longest = std::chrono::seconds(5);
    constexpr Duration between = std::chrono::milliseconds(20);
    if (!programs.any_was_told())
        return;
    const TimePoint end = session.clock().now() + longest;
    for (TimePoint now = session.clock().now(); now < end; now = session.clock().now()) {
        const auto opened = session.open(link);
        if (opened || opened.error().code != Errc::link_busy)
            return;
        session.clock().wait({}, now + between);
    }
}

/// A link without an id: whoever is there.
std::expected<std::vector<Done>, Error> stop_link(Session& session, const Words& words)
{
    const auto family = family_named(words.text("--family").value_or(""));
    if (!family)
        return std::unexpected(family.error());
    const auto device_with = [&](int id) {
        Words with_id = words;
        with_id.add("--id", std::to_string(id));
        return target(with_id);
    };
    std::vector<Done> done;
    if ((*family)->broadcast_id >= 0) {
        if (words.has("--hold"))
            return fail(Errc::bad_argument,
                        fmt::format("{} has no message that makes all devices of a line hold; add --id N, or name a "
                                    "robot file",
                                    (*family)->name));
        const auto everybody = device_with((*family)->broadcast_id);
        if (!everybody)
            return std::unexpected(everybody.error());
        done.push_back({fmt::format("all of {}", everybody->link), stop_line(session, *everybody)});
        return done;
    }
    Done none{"any id", fail(Errc::timeout, "nobody answered")};
    constexpr int attempts = 1; // most ids are nobody's
    for (auto id = (*family)->ids.low; id <= (*family)->ids.high; ++id) {
        const auto device = device_with(static_cast<int>(id));
        if (!device)
            return std::unexpected(device.error());
        Done one{device->name, stop_one(session, *device, words.has("--hold"), attempts)};
        if (one.outcome || one.outcome.error().code != Errc::timeout)
            done.push_back(std::move(one));
        if (!done.empty() && !done.back().outcome && done.back().outcome.error().code >= Errc::link_not_found &&
            done.back().outcome.error().code <= Errc::link_failed)
            return done;
    }
    if (done.empty())
        done.push_back(std::move(none));
    return done;
}

std::expected<std::vector<Done>, Error> stop_all(Session& session, const Words& words)
{
    const auto word = words.text("TARGET");
    Programs programs;
    if (word && is_link(*word) && !words.has("--id") && words.has("--family")) {
        if (auto told = programs.stop_holder(fmt::format("all of {}", *word), *word, -1))
            return std::vector<Done>{std::move(*told)};
        wait_for_port(session, programs, *word);
        return stop_link(session, words);
    }
    std::vector<Device> devices;
    if (word) {
        auto one = target(words);
        if (!one)
            return std::unexpected(one.error());
        devices.push_back(std::move(*one));
    } else if (auto all = whole_robot(words)) {
        devices = std::move(*all);
    } else {
        return std::unexpected(all.error());
    }
    std::vector<Done> done;
    std::vector<std::size_t> busy; // nobody else waits for a port that will be free
    for (const auto& device : devices) {
        const auto& name = device.name;
        if (auto stopped = programs.stop_holder(name, device.link, device.id)) {
            done.push_back(std::move(*stopped));
            continue;
        }
        done.push_back({name, stop_one(session, device, words.has("--hold"))});
        if (!done.back().outcome && done.back().outcome.error().code == Errc::link_busy)
            busy.push_back(done.size() - 1);
    }
    for (const auto i : busy) {
        wait_for_port(session, programs, devices[i].link);
        done[i].outcome = stop_one(session, devices[i], words.has("--hold"));
    }
    return done;
}

Outcome run(const Words& words)
{
    Session session;
    const auto done = stop_all(session, words);
    if (!done)
        return std::unexpected(done.error());
    int code = exit_done;
    Json out = Json::array();
    Table table({"NAME", "STATE"});
    for (const auto& one : *done) {
        if (one.outcome) {
            table.add({one.name, one.outcome->says});
            out.add(Json::object(
                {{"name", one.name}, {"state", one.outcome->says}, {"confirmed", one.outcome->confirmed}}));
            continue;
        }
        code = code == exit_done ? exit_code(one.outcome.error().code) : code;
        out.add(Json::object({{"name", one.name}, {"error", to_sentence(one.outcome.error())}, {"confirmed", false}}));
        fmt::print(stderr, "sinew: {} {}: {}\n", one.name, one.perhaps ? "may NOT have stopped" : "was NOT stopped",
                   to_sentence(one.outcome.error()));
    }
    if (words.json())
        print(out);
    else if (!table.empty())
        fmt::print("{}", table.text());
    return code;
}

} // namespace

Verb stop_verb()
{
    return {.name = "stop",
            .says = "Take the torque off one device or the whole robot; goes on past failures and says who failed.",
            .arguments = {{"TARGET", "a joint, or a link with --family; without it all joints of --robot", false}},
            .options = with_device_options({{"--hold", "", "stay in place with torque instead"}, json_option}),
            .examples = {{"sinew stop --robot arm.toml", "all joints; never asks"},
                         {"sinew stop serial:/dev/ttyUSB0 --family nuri --id 3",
                          "one device; without --id all on that link"}},
            .run = run,
            .more =
                "A joint that carries a load falls when it is released: --hold keeps it up. A program that holds the "
                "port and has a guardian is told to stop, and does what its robot file says under [safety]; where it "
                "cannot say that every device of a bus obeyed, that bus may not have stopped, and the exit code says "
                "so. \"not acknowledged\" is a device, or a message to all of a line, that answers nothing."};
}

} // namespace sinew::cli
