#include "apps/cli/exit_codes.hpp"
#include "apps/cli/present.hpp"
#include "apps/cli/stop_devices.hpp"
#include "apps/cli/stop_programs.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

bool is_lost_to(const std::expected<void, Error>& told)
{
    return !told && told.error().code >= Errc::link_not_found && told.error().code <= Errc::link_failed;
}

std::vector<Done> outcomes_of(std::span<const Stopping> all)
{
    std::vector<Done> out;
    for (const auto& one : all)
        out.push_back({one.device().name, one.outcome()});
    return out;
}

/// A link without an id, of a family that has no message for all: whoever is there.
std::expected<std::vector<Done>, Error> stop_whoever_answers(Session& session, const Words& words, const Family& family)
{
    std::vector<Stopping> there;
    for (auto id = family.ids.low; id <= family.ids.high; ++id) {
        Words with_id = words;
        with_id.add("--id", std::to_string(id));
        auto device = target(with_id);
        if (!device)
            return std::unexpected(device.error());
        Stopping one(session, std::move(*device), words.has("--hold"));
        one.tell(); // once: most ids are nobody's
        const auto told = one.confirmed();
        if (told || told.error().code != Errc::timeout)
            there.push_back(std::move(one));
        if (is_lost_to(told))
            break;
    }
    if (there.empty())
        return std::vector<Done>{{"any id", fail(Errc::timeout, "nobody answered")}};
    see_to_rest(session, there);
    return outcomes_of(there);
}

std::expected<std::vector<Done>, Error> stop_link(Session& session, const Words& words)
{
    const auto family = family_named(words.text("--family").value_or(""));
    if (!family)
        return std::unexpected(family.error());
    if ((*family)->broadcast_id < 0)
        return stop_whoever_answers(session, words, **family);
    if (words.has("--hold"))
        return fail(Errc::bad_argument,
                    fmt::format("{} has no message that makes all devices of a line hold; add --id N, or name a "
                                "robot file",
                                (*family)->name));
    Words to_all = words;
    to_all.add("--id", std::to_string((*family)->broadcast_id));
    const auto everybody = target(to_all);
    if (!everybody)
        return std::unexpected(everybody.error());
    return std::vector<Done>{{fmt::format("all of {}", everybody->link), stop_line(session, *everybody)}};
}

std::expected<std::vector<Done>, Error> stop_all(Session& session, const Words& words)
{
    const auto word = words.text("TARGET");
    if (word && is_link(*word) && !words.has("--id") && words.has("--family")) {
        Programs programs;
        if (auto told = programs.stop_holder(fmt::format("all of {}", *word), *word, -1))
            return std::vector<Done>{std::move(*told)};
        wait_for_port(session, programs, *word);
        return stop_link(session, words);
    }
    const auto devices = targets(words);
    if (!devices)
        return std::unexpected(devices.error());
    return stop_devices(session, *devices, !word, words.has("--hold"));
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
            .acts = true,
            .more =
                "All are told first, and then looked at until they stand still; one that does not answer, or turns on, "
                "was not stopped, and the exit code says so: switch its supply off. A joint that carries a load falls "
                "when it is released: --hold keeps it up. A program that holds the port and has a guardian is told to "
                "stop, and does what its robot file says under [safety]; where it cannot say that every device of a "
                "bus obeyed, that bus may not have stopped. \"not acknowledged\" is a device that answers no command, "
                "or a message to all of a line without ids, which nobody answers."};
}

} // namespace sinew::cli
