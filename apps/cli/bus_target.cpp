#include "apps/cli/bus_target.hpp"

#include "apps/cli/interrupt.hpp"
#include "apps/cli/scanning.hpp"
#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

std::uint32_t bit_rate_of(const std::string& link)
{
    const auto uri = link::parse_uri(link);
    if (!uri)
        return 0;
    const auto can = uri->number("bitrate");
    if (can && *can)
        return **can;
    // Of an SLCAN link, baud is that of the port to the adapter.
    const auto serial = uri->scheme != "slcan" ? uri->number("baud") : std::optional<std::uint32_t>{};
    return serial ? serial->value_or(0) : 0;
}

std::expected<BusTarget, Error> named_bus(const std::string& path, std::string_view name)
{
    auto buses = buses_of(path);
    if (!buses)
        return std::unexpected(buses.error());
    std::vector<std::string_view> names;
    for (auto& bus : *buses) {
        if (bus.name == name || (name.empty() && buses->size() == 1))
            return std::move(bus);
        names.push_back(bus.name);
    }
    if (name.empty())
        return fail(Errc::bad_argument, fmt::format("which bus of {}? It has {}", path, fmt::join(names, ", ")));
    return fail(Errc::unknown_name,
                fmt::format("{} has no bus '{}' with joints{}", path, name, suggestion(name, names)));
}

std::expected<void, Error> give_links(const Words& words, BusTarget& bus)
{
    if (auto given = give_links(words, bus.devices); !given)
        return given;
    bus.link = bus.devices.front().link;
    return {};
}

std::expected<BusTarget, Error> bus_on_link(const Words& words, const std::string& link)
{
    BusTarget out{.name = short_name(link), .link = link};
    if (const auto name = words.text("--family")) {
        const auto family = family_named(*name);
        if (!family)
            return std::unexpected(family.error());
        out.family = *family;
        out.link = with_bit_rate(link, **family);
    }
    out.bit_rate = bit_rate_of(out.link);
    const auto ids = words.all("--id");
    if (!ids.empty() && out.family == nullptr)
        return fail(Errc::bad_argument, "--id needs --family as well");
    for (const auto& id : ids) {
        Words one = words;
        one.add("--id", id); // the last one counts
        auto device = device_of(one, out.link);
        if (!device)
            return std::unexpected(device.error());
        out.devices.push_back(std::move(*device));
    }
    return out;
}

} // namespace

std::string short_name(const std::string& link)
{
    const auto uri = link::parse_uri(link);
    if (!uri)
        return link;
    const std::string& word = uri->fragment.empty() ? uri->target : uri->fragment;
    return word.substr(std::min(word.find_last_of('/') + 1, word.size()));
}

std::expected<std::vector<BusTarget>, Error> buses_of(const std::string& path)
{
    auto devices = devices_in(path);
    if (!devices)
        return std::unexpected(devices.error());
    std::vector<BusTarget> out;
    if (devices->empty())
        return out;
    const auto file = devices->front().file;
    for (const auto& bus : file->buses) {
        BusTarget one{.name = bus.name};
        for (auto& device : *devices)
            if (device.joint->bus.value == bus.name) {
                one.family = device.family;
                one.link = device.link;
                one.devices.push_back(std::move(device));
            }
        if (one.devices.empty())
            continue;
        one.bit_rate = bus.bit_rate ? static_cast<std::uint32_t>(bus.bit_rate->value) : bit_rate_of(one.link);
        if (one.bit_rate == 0)
            one.bit_rate = one.family->default_bit_rate;
        out.push_back(std::move(one));
    }
    return out;
}

std::expected<std::vector<BusTarget>, Error> robot_buses(const Words& words, const std::string& path)
{
    if (auto fine = no_family_for(words); !fine)
        return std::unexpected(fine.error());
    auto buses = buses_of(path);
    if (!buses)
        return buses;
    if (buses->empty())
        return no_joints(path);
    for (auto& bus : *buses)
        if (auto given = give_links(words, bus); !given)
            return std::unexpected(given.error());
    return buses;
}

std::expected<void, Error> find_devices(const Words& words, BusTarget& target)
{
    diagnosis::ScanPlan plan;
    if (target.family != nullptr)
        plan.families = {target.family};
    const std::string link = words.text("BUS").value_or("");
    if (const auto rate = bit_rate_of(link); rate != 0)
        plan.bit_rate = rate;
    std::vector<diagnosis::Found> found;
    if (auto looked = look_for_devices(link_to_open(link, plan), plan, found); !looked)
        return std::unexpected(looked.error());
    if (interrupted())
        return fail(Errc::stopped, "ended by Ctrl-C while it looked for devices");
    if (found.empty())
        return nobody_answered(link);
    target.family = found.front().family;
    target.link = with_bit_rate(link, *target.family, found.front().bit_rate);
    target.bit_rate = bit_rate_of(target.link);
    for (const auto& one : found) {
        if (one.family != target.family)
            return fail(Errc::bad_argument, fmt::format("{} and {} answer on {}; say which with --family",
                                                        target.family->name, one.family->name, link));
        Words named = words;
        named.add("--family", std::string(one.family->name));
        named.add("--id", std::to_string(one.id)); // the last one counts
        if (!words.has("--profile") && !one.line.empty())
            named.add("--profile", std::string(one.line));
        auto device = device_of(named, target.link);
        if (!device)
            return std::unexpected(device.error());
        target.devices.push_back(std::move(*device));
    }
    return {};
}

std::expected<BusTarget, Error> bus_target(const Words& words)
{
    const std::string word = words.text("BUS").value_or("");
    const auto uri = is_link(word) ? link::parse_uri(word) : std::expected<link::Uri, Error>{};
    if (!uri)
        return std::unexpected(uri.error());
    if (is_link(word))
        if (auto fine = no_sim_for(words, word); !fine)
            return std::unexpected(fine.error());
    if (is_link(word) && uri->scheme != "sim")
        return bus_on_link(words, word);
    for (const auto* option : {"--family", "--id", "--model", "--profile"})
        if (words.has(option))
            return fail(Errc::bad_argument,
                        fmt::format("{} goes with a link; for the bus {} the robot file says it", option, word));
    if (is_link(word)) {
        auto bus = named_bus(uri->target, uri->fragment);
        if (bus)
            bus->link = word;
        if (bus)
            for (auto& device : bus->devices)
                device.link = word;
        return bus;
    }
    const auto path = robot_path(words);
    if (!path && word.empty())
        return fail(Errc::bad_argument, "which bus? Name a link, or a bus with --robot FILE");
    if (!path)
        return fail(Errc::bad_argument, fmt::format("'{}' is no link; a bus by name needs --robot FILE", word));
    auto bus = named_bus(*path, word);
    if (!bus)
        return bus;
    if (auto given = give_links(words, *bus); !given)
        return std::unexpected(given.error());
    return bus;
}

} // namespace sinew::cli
