#include "apps/cli/session.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/family/drivers.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

constexpr std::string_view how_to_name_a_device =
    "name a joint with --robot FILE, or a link with --family and --id, such as serial:/dev/ttyUSB0?baud=1500000 "
    "--family sam --id 1";

std::expected<std::shared_ptr<const config::RobotFile>, Error> read_robot(const std::string& path)
{
    auto file = config::read_robot_file(path);
    if (!file)
        return std::unexpected(file.error());
    return std::make_shared<const config::RobotFile>(std::move(*file));
}

std::expected<std::string, Error> link_of(const std::map<std::string, std::string>& given, const Device& device)
{
    const auto& file = *device.file;
    const auto& bus = *file.find_bus(device.joint->bus.value);
    const auto named = given.find(bus.name);
    const std::string link = named != given.end() ? named->second : bus.link ? bus.link->value : std::string{};
    if (link.empty())
        return fail(
            Errc::bad_argument,
            fmt::format("bus {} of {} has no link: give it with --link {}=LINK, as `sinew sim {}` prints it, or "
                        "write link = \"...\" into the file",
                        bus.name, file.path, bus.name, file.path));
    const auto rate = bus.bit_rate ? static_cast<std::uint32_t>(bus.bit_rate->value) : 0;
    return with_bit_rate(link, *device.family, rate);
}

std::expected<std::vector<Device>, Error> joints_of(const Words& words, const std::string& path,
                                                    std::optional<std::string_view> only)
{
    auto all = devices_in(path);
    if (!all)
        return all;
    std::vector<std::string_view> names;
    for (const auto& device : *all)
        names.push_back(device.joint->name);
    if (only && std::ranges::find(names, *only) == names.end())
        return fail(Errc::unknown_name,
                    fmt::format("{} has no joint '{}'{}", path, *only,
                                nearest(*only, names).empty() ? fmt::format("; it has {}", fmt::join(names, ", "))
                                                              : did_you_mean(*only, names)));
    if (only)
        std::erase_if(*all, [&](const Device& device) { return device.joint->name != *only; });
    if (auto given = give_links(words, *all); !given)
        return std::unexpected(given.error());
    return all;
}

} // namespace

std::expected<bus::Settings, Error> bus_settings()
{
    bus::Settings settings;
    const char* word = std::getenv("SINEW_PATIENCE");
    if (word == nullptr || *word == '\0')
        return settings;
    const auto patience = duration_from("SINEW_PATIENCE", word);
    if (!patience)
        return std::unexpected(patience.error());
    for (Duration* margin : {&settings.margin_at_first, &settings.margin_least, &settings.margin_most})
        *margin = std::max(*margin, *patience);
    return settings;
}

std::optional<std::string> robot_path(const Words& words)
{
    if (const auto given = words.text("--robot"))
        return given;
    const char* environment = std::getenv("SINEW_ROBOT");
    return environment != nullptr && *environment != '\0' ? std::optional<std::string>(environment) : std::nullopt;
}

std::expected<std::vector<Device>, Error> devices_in(const std::string& path)
{
    const auto file = read_robot(path);
    if (!file)
        return std::unexpected(file.error());
    auto robot = resolve(**file);
    if (!robot)
        return std::unexpected(robot.error());
    std::vector<Device> out;
    for (auto& joint : robot->joints)
        out.push_back({.name = joint.joint->name,
                       .link = joint.bus->link ? joint.bus->link->value : std::string{},
                       .family = joint.family,
                       .id = sinew::id_of(joint.device),
                       .spec = std::move(joint.device),
                       .joint = joint.joint,
                       .file = *file});
    return out;
}

std::expected<void, Error> give_links(const Words& words, std::vector<Device>& devices)
{
    for (auto& device : devices) {
        const auto given = given_links(words, *device.file);
        if (!given)
            return std::unexpected(given.error());
        auto link = link_of(*given, device);
        if (!link)
            return std::unexpected(link.error());
        device.link = std::move(*link);
    }
    return {};
}

bool is_link(std::string_view word)
{
    return word.find(':') != std::string_view::npos || word.find('/') != std::string_view::npos;
}

std::string with_bit_rate(const std::string& link, const Family& family, std::uint32_t bit_rate)
{
    const auto uri = link::parse_uri(link);
    if (!uri || family.can || (uri->scheme != "serial" && uri->scheme != "rs485") || uri->option("baud"))
        return link;
    auto with = *uri;
    with.options.emplace_back("baud", std::to_string(bit_rate != 0 ? bit_rate : family.default_bit_rate));
    return link::to_string(with);
}

std::expected<std::map<std::string, std::string>, Error> given_links(const Words& words, const config::RobotFile& file)
{
    std::vector<std::string_view> names;
    for (const auto& bus : file.buses)
        names.push_back(bus.name);
    std::map<std::string, std::string> out;
    for (const std::string_view word : words.all("--link")) {
        const auto equals = std::min(word.find('='), word.size());
        const auto bus = word.substr(0, equals);
        if (equals == word.size() || !is_link(word.substr(equals + 1)))
            return fail(
                Errc::bad_argument,
                fmt::format("--link takes BUS=LINK, such as left=serial:/dev/ttyUSB0?baud=1500000, not '{}'", word));
        if (std::ranges::find(names, bus) == names.end())
            return fail(Errc::unknown_name,
                        fmt::format("{} has no bus '{}'{}", file.path, bus,
                                    nearest(bus, names).empty() ? fmt::format("; it has {}", fmt::join(names, ", "))
                                                                : did_you_mean(bus, names)));
        out.insert_or_assign(std::string(bus), std::string(word.substr(equals + 1)));
    }
    return out;
}

Session::Session() : links_(link::Links::system())
{
    sim::add(links_, worlds_);
    record::add(links_, replays_);
    catch_interrupts();
}

std::expected<link::AnyLink, Error> Session::open(const std::string& link)
{
    const auto clock = record::is_replay(link) ? replays_.clock_for(link) : sim::clock_for(link, real_, worlds_);
    if (!clock)
        return std::unexpected(clock.error());
    if (!open_.empty() && *clock != clock_)
        return fail(Errc::bad_argument, fmt::format("{} and {} have no common time; add clock=real to a simulated one",
                                                    open_.front().link, link));
    auto opened = links_.open(link, **clock);
    if (opened)
        clock_ = *clock;
    return opened;
}

std::expected<bus::Bus*, Error> Session::bus_of(const Device& device)
{
    auto known = std::ranges::find(open_, device.link, &Open::link);
    if (known == open_.end()) {
        auto link = open(device.link);
        if (!link)
            return std::unexpected(link.error());
        if (device.family->can != std::holds_alternative<std::unique_ptr<link::CanLink>>(*link))
            return fail(Errc::bad_argument, fmt::format("{} devices are on {}, which {} is not", device.family->name,
                                                        device.family->can ? "CAN" : "serial lines", device.link));
        const auto settings = bus_settings();
        if (!settings)
            return std::unexpected(settings.error());
        auto bus =
            std::make_unique<bus::Bus>(device.link, std::move(*link), *clock_, *device.family->protocol, *settings);
        bus->set_reopen(links_.reopener(device.link, *clock_));
        auto stop = std::make_unique<StopOnInterrupt>(*bus);
        known = open_.insert(open_.end(), Open{device.link, device.family, std::move(bus), std::move(stop)});
    }
    if (known->family != device.family)
        return fail(Errc::bad_argument, fmt::format("{} is used by {} and {}; one bus carries one family", device.link,
                                                    known->family->name, device.family->name));
    known->bus->set_device(device.id, {.options = device.options(), .response_time = device.response_time()});
    return known->bus.get();
}

std::vector<bus::Bus*> Session::buses() const
{
    std::vector<bus::Bus*> out;
    for (const auto& open : open_)
        out.push_back(open.bus.get());
    return out;
}

bool has_robot(const Words& words)
{
    return robot_path(words).has_value();
}

std::expected<Device, Error> target(const Words& words)
{
    const std::string word = words.text("TARGET").value_or("");
    if (is_link(word)) {
        auto device = device_of(words, word);
        if (device)
            device->link = with_bit_rate(device->link, *device->family);
        return device;
    }
    const auto path = robot_path(words);
    if (!path)
        return fail(Errc::bad_argument,
                    fmt::format("'{}' is no link, and there is no robot file that could have such a "
                                "joint: {}",
                                word, how_to_name_a_device));
    for (const auto* option : {"--family", "--id", "--model", "--profile"})
        if (words.has(option))
            return fail(Errc::bad_argument,
                        fmt::format("{} goes with a link; for the joint {} the robot file says it", option, word));
    auto joints = joints_of(words, *path, word);
    if (!joints)
        return std::unexpected(joints.error());
    return std::move(joints->front());
}

std::expected<std::vector<Device>, Error> whole_robot(const Words& words)
{
    const auto path = robot_path(words);
    if (!path)
        return fail(Errc::bad_argument, fmt::format("which device? Please {}", how_to_name_a_device));
    return robot_at(words, *path);
}

std::expected<std::vector<Device>, Error> robot_at(const Words& words, const std::string& path)
{
    return joints_of(words, path, std::nullopt);
}

std::expected<void, Error> find_model(Device& device, bus::Bus& bus)
{
    if (device.spec || !device.family->ids.contains(device.id))
        return {};
    const auto said = bus.call(device.id, sam::ReadFirmwareVersion{});
    if (!said)
        return std::unexpected(said.error());
    if (const auto* model = sam::find_model(said->model_number)) {
        auto spec = make_spec(*device.family, model->name, device.asked_line->name, device.id);
        if (!spec)
            return std::unexpected(spec.error());
        device.spec = std::move(*spec);
    }
    return {};
}

std::expected<Driven, Error> drive(Session& session, Device device)
{
    const auto bus = session.bus_of(device);
    if (!bus)
        return std::unexpected(bus.error());
    if (auto found = find_model(device, **bus); !found)
        return std::unexpected(found.error());
    if (!device.spec)
        return fail(
            Errc::unsupported,
            fmt::format("{} says a model that is not documented; name one with --model to drive it", device.name));
    auto driver = make_driver(*device.spec);
    return Driven{.device = std::move(device), .bus = *bus, .driver = std::move(driver)};
}

std::expected<void, Error> carry_out(Driven& driven, const wire::Requests& requests)
{
    std::array<bus::Result, wire::Requests::capacity> results;
    const auto used = std::span(results).first(requests.all().size());
    if (auto sent = driven.bus->exchange(requests.all(), used); !sent)
        return std::unexpected(sent.error());
    for (std::size_t i = 0; i < used.size(); ++i) {
        const auto reply = used[i].reply();
        if (!reply)
            return std::unexpected(reply.error());
        if (!requests.all()[i].answered)
            continue;
        if (auto read = driven.driver->absorb(requests.all()[i], *reply, used[i].at, driven.state); !read)
            return fail(Errc::bad_reply,
                        fmt::format("the answer of {} is wrong: {}", driven.device.name, to_sentence(read.error())));
    }
    return {};
}

std::expected<void, Error> set_up(Driven& driven)
{
    const auto settings = driven.driver->plan_settings();
    if (!settings)
        return std::unexpected(settings.error());
    return settings->empty() ? std::expected<void, Error>{} : carry_out(driven, *settings);
}

std::expected<void, Error> read_state(Driven& driven, actuator::Depth depth)
{
    const auto requests = driven.driver->plan_read(depth);
    if (!requests)
        return std::unexpected(requests.error());
    // What this look does not measure is not known: an older speed beside a new position belongs to no moment.
    driven.state = {};
    return carry_out(driven, *requests);
}

std::expected<void, Error> hold(Driven& driven)
{
    const actuator::Command command{.mode = actuator::Mode::hold};
    auto requests = driven.driver->plan(command, {});
    if (!requests) {
        if (auto read = read_state(driven, actuator::Depth::motion); !read)
            return read;
        requests = driven.driver->plan(command, driven.state);
    }
    return requests ? carry_out(driven, *requests) : std::unexpected(requests.error());
}

std::expected<wire::Values, Error> ask(bus::Bus& bus, const wire::Request& request)
{
    bus::Result result;
    if (auto sent = bus.exchange({&request, 1}, {&result, 1}); !sent)
        return std::unexpected(sent.error());
    const auto reply = result.reply();
    if (!reply)
        return std::unexpected(reply.error());
    if (!request.answered)
        return wire::Values{};
    return reply_values(request, *reply);
}

void wait_until(Session& session, TimePoint until)
{
    const auto buses = session.buses();
    std::vector<link::Handle> handles;
    while (!interrupted() && session.clock().now() < until) {
        TimePoint next = until;
        handles.clear();
        for (auto* bus : buses) {
            next = std::min(next, bus->tend());
            const auto of_bus = bus->handles();
            handles.insert(handles.end(), of_bus.begin(), of_bus.end());
        }
        session.clock().wait(handles, next);
    }
}

} // namespace sinew::cli
