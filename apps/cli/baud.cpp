#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/fields.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/presence.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

/// A receiver samples the middle of the last of ten bits: half a bit off in all, for both ends.
constexpr double most_off = 0.025;

struct Change {
    wire::Request request;
    std::uint32_t bit_rate = 0;
};

std::expected<Change, Error> change_from(const Words& words, const Device& device)
{
    const Family& family = *device.family;
    const auto wanted = words.number("BIT-RATE", 1, 100'000'000);
    if (!wanted)
        return std::unexpected(wanted.error());
    const auto* message = device.line().find("set-baud-rate");
    if (message == nullptr)
        return fail(Errc::unsupported, fmt::format("{} has no message that sets a bit rate; a CAN bus has one rate for "
                                                   "all that are on it",
                                                   family.name));
    if (!family.ids.contains(device.id))
        return fail(Errc::bad_id, fmt::format("id {} is every device of the line, and none of them would confirm it; "
                                              "name one after the other",
                                              device.id));
    const auto rate = std::ranges::find(family.bit_rates, **wanted, &BitRate::bps);
    if (rate == family.bit_rates.end()) {
        std::vector<std::uint32_t> rates;
        for (const auto& one : family.bit_rates)
            rates.push_back(one.bps);
        std::ranges::sort(rates);
        return fail(Errc::bad_argument,
                    fmt::format("{} has no bit rate {}; it has {}", family.name, **wanted, fmt::join(rates, ", ")));
    }
    const std::string word = fmt::format("baud_code={}", rate->code);
    auto asked = request_from(device, *message, {&word, 1});
    if (!asked)
        return std::unexpected(asked.error());
    return Change{.request = *asked, .bit_rate = rate->bps};
}

/// Whether this host's end can follow, before anything is written: it is set there and back.
std::expected<void, Error> host_can(bus::Bus& bus, std::uint32_t old_rate, std::uint32_t new_rate)
{
    const auto real = bus.set_bit_rate(new_rate);
    const auto back = bus.set_bit_rate(old_rate);
    if (!real)
        return fail(Errc::unsupported, fmt::format("this end of the line cannot follow to {} bps ({}); nothing was "
                                                   "written",
                                                   new_rate, to_sentence(real.error())));
    if (!back)
        return std::unexpected(back.error());
    const double off = std::abs(static_cast<double>(*real) - new_rate) / new_rate;
    if (off > most_off)
        return fail(Errc::unsupported, fmt::format("this adapter makes {} bps of {}, which is {:.1f} % off and more "
                                                   "than a device can read; nothing was written",
                                                   *real, new_rate, 100.0 * off));
    return {};
}

std::string with_rate(const std::string& link, std::uint32_t bit_rate)
{
    auto uri = link::parse_uri(link);
    if (!uri || uri->scheme == "sim")
        return link;
    std::erase_if(uri->options, [](const auto& option) { return option.first == "baud"; });
    uri->options.emplace_back("baud", std::to_string(bit_rate));
    return link::to_string(*uri);
}

Outcome done(const Words& words, const Device& device, std::uint32_t old_rate, std::uint32_t new_rate)
{
    const bool changed = old_rate != new_rate;
    if (words.json())
        print(Json::object({{"device", device.name},
                            {"family", device.family->name},
                            {"id", device.id},
                            {"link", with_rate(device.link, new_rate)},
                            {"old_bit_rate", old_rate},
                            {"bit_rate", new_rate},
                            {"changed", changed}}));
    else
        fmt::print("{} {} {} bps\n", device.name, changed ? "answers at" : "has", new_rate);
    if (changed)
        fmt::print(stderr, "The other devices of this line keep {} bps and are not heard at {}. Next time: {}{}\n",
                   old_rate, new_rate, with_rate(device.link, new_rate),
                   device.joint != nullptr
                       ? fmt::format(", or bit_rate = {} under [bus.{}]", new_rate, device.joint->bus.value)
                       : std::string{});
    return exit_done;
}

/// Whether a device of that id answers at a rate, where this end stays.
std::expected<bool, Error> is_heard_at(bus::Bus& bus, const Device& device, std::uint32_t rate)
{
    if (const auto set = bus.set_bit_rate(rate); !set)
        return std::unexpected(set.error());
    const auto answer = ask(bus, *probe(device, device.id));
    if (answer || answer.error().code == Errc::timeout ||
        (answer.error().code >= Errc::bad_length && answer.error().code <= Errc::bad_reply))
        return answer.has_value();
    return std::unexpected(answer.error());
}

/// Two devices with one id answer at once, and neither could be given another one.
std::expected<void, Error> is_free_at(bus::Bus& bus, const Device& device, std::uint32_t old_rate,
                                      std::uint32_t new_rate)
{
    const auto taken = is_heard_at(bus, device, new_rate);
    if (const auto back = bus.set_bit_rate(old_rate); !back)
        return std::unexpected(back.error());
    if (!taken)
        return std::unexpected(taken.error());
    if (*taken)
        return fail(Errc::bad_id, fmt::format("another device with id {} answers at {} bps already; give one of them "
                                              "another id first (sinew id); nothing was written",
                                              device.id, new_rate));
    return {};
}

/// At the new rate, else back at the old one: this end goes where the device is.
Outcome verify(const Words& words, bus::Bus& bus, const Device& device, std::uint32_t old_rate, std::uint32_t new_rate)
{
    for (const auto rate : {new_rate, old_rate}) {
        const auto heard = is_heard_at(bus, device, rate);
        if (!heard)
            return std::unexpected(heard.error());
        if (*heard && rate == new_rate)
            return done(words, device, old_rate, new_rate);
        if (*heard)
            return fail(Errc::unsupported,
                        fmt::format("{} still answers at {} bps and not at {}: it has not taken the rate, or takes it "
                                    "when it is switched on next; this end is back at {} bps",
                                    device.name, old_rate, new_rate, old_rate));
    }
    return fail(Errc::timeout, fmt::format("{} answers neither at {} nor at {} bps any more; sinew scan {} looks at "
                                           "all rates",
                                           device.name, new_rate, old_rate, device.link));
}

Outcome run(const Words& words)
{
    const auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    const auto change = change_from(words, *device);
    if (!change)
        return std::unexpected(change.error());
    if (words.has("--dry-run")) {
        show_unsent(words, *device, {&change->request, 1});
        return exit_done;
    }
    const auto yes = confirm(words, fmt::format("{} will talk at {} bps, which writes its flash; the other devices of "
                                                "the line keep their rate",
                                                device->name, change->bit_rate));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    Session session;
    const auto bus = session.bus_of(*device);
    if (!bus)
        return std::unexpected(bus.error());
    const std::uint32_t old_rate = (*bus)->link_state().bit_rate;
    if (const auto there = ask(**bus, *probe(*device, device->id)); !there)
        return std::unexpected(there.error());
    if (change->bit_rate == old_rate)
        return done(words, *device, old_rate, old_rate);
    if (auto can = host_can(**bus, old_rate, change->bit_rate); !can)
        return std::unexpected(can.error());
    if (auto is_free = is_free_at(**bus, *device, old_rate, change->bit_rate); !is_free)
        return std::unexpected(is_free.error());
    if (auto sent = write_once(**bus, *device, change->request); !sent)
        return std::unexpected(sent.error());
    return verify(words, **bus, *device, old_rate, change->bit_rate);
}

} // namespace

Verb baud_verb()
{
    return {.name = "baud",
            .says = "Give a device another bit rate, follow it there, and see that it answers.",
            .arguments = {target_argument, {"BIT-RATE", "in bits per second, such as 115200"}},
            .options = with_device_options({dry_run_option, yes_option, json_option}),
            .examples = {{"sinew baud waist_yaw 1000000 --robot arm.toml", "asks first"},
                         {"sinew baud serial:/dev/ttyUSB0?baud=9600 115200 --family nuri --id 0 --yes",
                          "a new actuator, as delivered"},
                         {"sinew baud elbow 115200 --robot arm.toml --sim --yes", "a simulated one"}},
            .run = run,
            .acts = true,
            .more = "The rate is stored in flash. That this end of the line can follow, and that nobody answers there "
                    "with the same id, is tried before anything is written. Where the device does not answer at the "
                    "new rate, this end goes back and looks for it "
                    "at the old one. RMD motors have no such message."};
}

} // namespace sinew::cli
