#include "apps/cli/session.hpp"

#include "apps/cli/robot_record.hpp"
#include "sinew/family/drivers.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/robot/hold_unseen.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>

namespace sinew::cli {

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

std::expected<robot::Guardian, Error> start_guardian(std::optional<Duration> patience)
{
    // Far longer than it is without a sign of life by itself: it shows one every 20 ms, and waits for a disk or a
    // terminal.
    constexpr Duration least = std::chrono::milliseconds(500);
    constexpr Duration unless_told = std::chrono::seconds(3);
    const auto settings = bus_settings();
    if (!settings)
        return std::unexpected(settings.error());
    // Also for a program that is stopped by a signal that nobody can catch.
    return robot::Guardian::start(
        {.patience = std::max(patience.value_or(unless_told), least) + 4 * settings->margin_most});
}

Session::Session() : links_(link::Links::system())
{
    sim::add(links_, worlds_);
    record::add(links_, replays_);
    catch_interrupts();
}

std::expected<void, Error> Session::guard(const Device& device)
{
    catch_suspension();
    if (guardian_ || record::is_replay(device.link) || sim::is_simulated(device.link))
        return {};
    auto guardian = start_guardian();
    if (!guardian)
        return std::unexpected(guardian.error());
    guardian_.emplace(std::move(*guardian));
    return {};
}

void Session::heed_guardian()
{
    if (!guardian_ || interrupted())
        return;
    guardian_->beat();
    if (guardian_->stop_asked()) {
        fmt::print(
            stderr,
            "sinew: stopped from outside: by sinew stop, or by the guardian of this program, which found it hanging\n");
        interrupt();
    } else if (!guardian_->is_alive()) {
        fmt::print(stderr,
                   "sinew: the guardian of this program was killed; nothing would stop the motor if the program "
                   "died\n");
        interrupt();
    }
}

MotionGuard::MotionGuard(robot::Guardian& guardian, const Device& device)
    : guardian_(guardian), stopper_(make_driver(*device.spec)), stop_{.mode = robot::hold_unseen(*stopper_)},
      link_(fmt::format("{}#{}", device.link, device.id))
{
}

std::expected<void, Error> MotionGuard::update(Driven& driven)
{
    guardian_.beat();
    if (driven.bus->link_trouble() != nullptr) {
        if (known_)
            guardian_.forget(0);
        known_.reset();
        return {};
    }
    const auto requests = stopper_->plan(stop_, {});
    if (!requests)
        return std::unexpected(requests.error());
    const robot::StopFrames frames{.seen = requests->all(), .unseen = requests->all()};
    if (known_ == driven.bus->losses()) {
        guardian_.update(0, driven.bus->link(), frames);
        return {};
    }
    auto watched = guardian_.watch(0, link_, driven.bus->link(), frames);
    if (watched)
        known_ = driven.bus->losses();
    return watched;
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

std::expected<void, Error> find_model(Device& device, bus::Bus& bus)
{
    if (device.spec || !device.family->ids.contains(device.id))
        return {};
    const auto said = bus.call(device.id, sam::ReadFirmwareVersion{});
    if (!said)
        return std::unexpected(about(device, said.error()));
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
    return Driven{.device = std::move(device), .bus = *bus, .driver = std::move(driver), .guard = nullptr};
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
            return std::unexpected(about(driven.device, reply.error()));
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
    const auto read = carry_out(driven, *requests);
    if (driven.record != nullptr)
        driven.record->said(driven);
    const auto kept = driven.guard ? driven.guard->update(driven) : read;
    return read ? kept : read;
}

bool may_pass(Errc code)
{
    return code >= Errc::timeout && code <= Errc::bad_reply;
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
    constexpr Duration between_looks = std::chrono::milliseconds(20); // at the guardian
    for (session.heed_guardian(); !interrupted() && session.clock().now() < until; session.heed_guardian()) {
        TimePoint next = session.guardian() != nullptr ? std::min(until, session.clock().now() + between_looks) : until;
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
