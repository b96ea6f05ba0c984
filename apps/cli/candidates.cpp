#include "apps/cli/candidates.hpp"

#include "apps/cli/help.hpp"
#include "apps/cli/names.hpp"
#include "apps/cli/session.hpp"
#include "sinew/sim/fault.hpp"

#include <algorithm>

namespace sinew::cli {
namespace {

/// What has been written before the word that is completed.
struct Line {
    const Verb* verb = nullptr;
    Words words;
    std::size_t positionals = 0;
    const Option* open = nullptr; ///< that waits for its value
};

const Option* find_option(const Verb& verb, std::string_view name)
{
    const auto found = std::ranges::find(verb.options, name, &Option::name);
    return found == verb.options.end() ? nullptr : &*found;
}

const Verb* verb_named(std::string_view name)
{
    const auto found = std::ranges::find(verbs(), name, &Verb::name);
    return found == verbs().end() ? nullptr : &*found;
}

Line read(const Verb& verb, std::span<const std::string> before)
{
    Line out{.verb = &verb};
    for (const auto& word : before) {
        if (out.open != nullptr) {
            out.words.add(std::exchange(out.open, nullptr)->name, word);
        } else if (word.starts_with("--")) {
            const auto* option = find_option(verb, word);
            if (option != nullptr && !option->value.empty())
                out.open = option;
            else if (option != nullptr)
                out.words.add(option->name, "");
        } else {
            const auto at = std::min(out.positionals, verb.arguments.empty() ? 0 : verb.arguments.size() - 1);
            if (!verb.arguments.empty())
                out.words.add(verb.arguments[at].name, word);
            ++out.positionals;
        }
    }
    return out;
}

std::vector<Device> robot(const Words& words)
{
    const auto path = robot_path(words);
    auto devices = path ? devices_in(*path) : std::expected<std::vector<Device>, Error>{};
    return devices ? std::move(*devices) : std::vector<Device>{};
}

/// The device that the line names so far.
std::optional<Device> device_on(const Words& words)
{
    const auto name = words.text("TARGET").value_or("");
    if (!is_link(name)) {
        for (auto& device : robot(words))
            if (device.name == name)
                return std::move(device);
        return std::nullopt;
    }
    Words with_id = words;
    if (const auto* family = find_family(words.text("--family").value_or("")); family != nullptr && !words.has("--id"))
        with_id.add("--id", std::to_string(family->default_id));
    auto device = device_of(with_id, name);
    return device ? std::optional(std::move(*device)) : std::nullopt;
}

std::vector<std::string> families_list()
{
    std::vector<std::string> out;
    for (const auto* family : families())
        out.emplace_back(family->name);
    return out;
}

std::vector<std::string> bus_names(const Words& words, std::string_view ending)
{
    std::vector<std::string> out;
    for (const auto& device : robot(words)) {
        auto name = device.joint->bus.value + std::string(ending);
        if (std::ranges::find(out, name) == out.end())
            out.push_back(std::move(name));
    }
    return out;
}

/// Of the robot file; `sequences`: those as well.
std::vector<std::string> pose_names(const Words& words, bool sequences)
{
    const auto path = robot_path(words);
    const auto file = path ? config::read_robot_file(*path) : std::expected<config::RobotFile, Error>{};
    std::vector<std::string> out;
    if (!file)
        return out;
    for (const auto& pose : file->poses)
        out.push_back(pose.name);
    if (sequences)
        for (const auto& sequence : file->sequences)
            out.push_back(sequence.name);
    return out;
}

template <class Name>
std::vector<std::string> message_names(const Words& words, const Name& name)
{
    std::vector<std::string> out;
    const auto device = device_on(words);
    const auto family = words.text("FAMILY").value_or(words.text("--family").value_or(""));
    const auto* line = device                           ? &device->line()
                       : find_family(family) != nullptr ? find_family(family)->profiles.front()
                                                        : nullptr;
    if (line != nullptr)
        for (const auto* message : line->messages)
            if (const std::optional<std::string> word = name(*message))
                out.push_back(*word);
    return out;
}

std::vector<std::string> values(const Line& line, std::string_view kind)
{
    const auto& words = line.words;
    std::vector<std::string> out;
    const bool names_joint = line.open != nullptr && line.open->name == "--joint";
    if (names_joint || kind == "TARGET" || kind == "JOINT" || (kind == "NAME" && line.verb->name == "sim step")) {
        for (const auto& device : robot(words))
            out.push_back(device.name);
    } else if (kind == "POSE" || (kind == "NAME" && line.verb->name == "play")) {
        out = pose_names(words, kind == "NAME");
    } else if (kind == "F" || kind == "FAMILY") {
        out = families_list();
    } else if (kind == "BUS") {
        out = bus_names(words, "");
    } else if (kind == "BUS=LINK") {
        out = bus_names(words, "=");
    } else if (kind == "MESSAGE" || (kind == "NAME" && line.verb->name == "messages")) {
        out = message_names(words, [](const auto& message) { return std::optional(std::string(message.name())); });
    } else if (kind == "NAME" && line.verb->name == "get") {
        out = message_names(words, reads_what);
    } else if (kind == "NAME" && line.verb->name == "set") {
        out = message_names(words, sets_what);
    } else if (kind == "KIND") {
        for (const auto& fault : sim::fault_kinds())
            out.emplace_back(fault.word);
    } else if (kind == "SHELL") {
        out = {"bash", "zsh", "fish"};
    } else if (kind == "M" || kind == "P") {
        for (const auto* family : families()) {
            if (words.has("--family") && words.text("--family") != family->name)
                continue;
            for (const auto& model : family->models)
                if (kind == "M")
                    out.emplace_back(model.name);
            for (const auto* profile : family->profiles)
                if (kind == "P")
                    out.emplace_back(profile->name);
        }
    }
    return out;
}

std::vector<std::string> options_of(const Verb& verb)
{
    std::vector<std::string> out{"--help"};
    for (const auto& option : verb.options)
        out.emplace_back(option.name);
    return out;
}

/// The first words of all verbs, or the second ones of those that begin with `first`.
std::vector<std::string> verb_words(std::string_view first)
{
    std::vector<std::string> out;
    for (const auto& verb : verbs()) {
        const auto blank = verb.name.find(' ');
        const auto head = verb.name.substr(0, blank);
        const auto word = first.empty()                                      ? head
                          : head == first && blank != std::string_view::npos ? verb.name.substr(blank + 1)
                                                                             : std::string_view{};
        if (!word.empty() && std::ranges::find(out, word) == out.end())
            out.emplace_back(word);
    }
    if (first.empty())
        out.insert(out.end(), {"help", "--help", "--version"});
    return out;
}

std::vector<std::string> all_candidates(std::span<const std::string> line)
{
    if (line.size() <= 2)
        return verb_words("");
    const std::string& first = line[1];
    if (first == "help") {
        auto out = verb_words("");
        for (const auto& topic : help_topics())
            out.emplace_back(topic.name);
        return out;
    }
    const Verb* pair = line.size() > 3 ? verb_named(first + " " + line[2]) : nullptr;
    const Verb* verb = pair != nullptr ? pair : verb_named(first);
    std::vector<std::string> out;
    if (pair == nullptr && line.size() == 3)
        out = verb_words(first);
    if (verb == nullptr)
        return out;
    const auto before = line.subspan(pair != nullptr ? 3 : 2);
    const Line known = read(*verb, before.first(before.size() - 1));
    if (known.open != nullptr)
        return values(known, known.open->value);
    if (line.back().starts_with('-'))
        return options_of(*verb);
    if (!verb->arguments.empty()) {
        const auto at = std::min(known.positionals, verb->arguments.size() - 1);
        if (known.positionals < verb->arguments.size() || verb->arguments.back().many) {
            const auto more = values(known, verb->arguments[at].name);
            out.insert(out.end(), more.begin(), more.end());
        }
    }
    return out;
}

} // namespace

std::vector<std::string> candidates(std::span<const std::string> line)
{
    if (line.empty())
        return {};
    auto out = all_candidates(line);
    std::erase_if(out, [&](const std::string& word) { return !word.starts_with(line.back()); });
    return out;
}

} // namespace sinew::cli
