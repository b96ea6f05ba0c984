#include "sinew/link/links.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/link/serial.hpp"
#include "sinew/link/slcan_opening.hpp"
#include "sinew/link/socketcan.hpp"
#include "sinew/link/tcp.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::link {
namespace {

template <class Link>
auto opener(std::expected<std::unique_ptr<Link>, Error> (*open)(const Uri&, Clock&))
{
    return [open](const Uri& uri, Clock& clock) -> std::expected<AnyLink, Error> {
        auto link = open(uri, clock);
        if (!link)
            return std::unexpected(link.error());
        return AnyLink{std::move(*link)};
    };
}

/// Ends the sentence, with the nearest word where one is near.
std::string suggest(std::string_view word, std::span<const std::string_view> candidates)
{
    const auto nearest_word = did_you_mean(word, candidates);
    return nearest_word.empty() ? "." : nearest_word;
}

std::unexpected<Error> refuse_scheme(const Uri& uri, std::span<const Scheme> schemes)
{
    if (!uri.target.empty() && uri.target.find_first_not_of("0123456789") == std::string::npos)
        return fail(Errc::bad_uri, fmt::format("'{0}:{1}' has no scheme: write tcp://{0}:{1}", uri.scheme, uri.target));
    std::vector<std::string_view> names;
    for (const Scheme& scheme : schemes)
        names.push_back(scheme.name);
    return fail(Errc::bad_uri, fmt::format("there is no link of kind '{}'{} The kinds are {}.", uri.scheme,
                                           suggest(uri.scheme, names), fmt::join(names, ", ")));
}

std::unexpected<Error> refuse_option(std::string_view option, const Scheme& scheme)
{
    if (scheme.options.empty())
        return fail(Errc::bad_uri, fmt::format("{}: has no options, so '{}' means nothing", scheme.name, option));
    return fail(Errc::bad_uri, fmt::format("{}: has no option '{}'{} It has {}.", scheme.name, option,
                                           suggest(option, scheme.options), fmt::join(scheme.options, ", ")));
}

Reopen reopen_serial(const Uri& uri, Clock& clock)
{
    return [uri, &clock] { return opener<ByteLink>(&open_serial)(uri, clock); };
}

/// Of the port of an adapter: see `Links::reopener`.
auto device_reopener(Reopen (*reopen)(const Uri&, Clock&), const Roots& roots)
{
    return [reopen, roots](const Uri& uri, Clock& clock) -> Reopen {
        Uri again = uri;
        std::error_code none;
        if (!std::filesystem::is_symlink(uri.target, none) && !find_serial_number(uri.target, roots).empty())
            if (auto by_id = find_by_id(uri.target, roots); !by_id.empty())
                again.target = std::move(by_id);
        return reopen(again, clock);
    };
}

} // namespace

Links Links::system(const Roots& roots)
{
    const auto serial = opener<ByteLink>(&open_serial);
    Links links;
    links.add({.name = "serial",
               .form = "serial:DEVICE?baud=RATE",
               .says = "A serial port; echo=on where the adapter hears itself, auto to find out.",
               .options = {"baud", "echo"},
               .open = serial,
               .reopener = device_reopener(&reopen_serial, roots)});
    links.add({.name = "rs485",
               .form = "rs485:DEVICE?baud=RATE",
               .says = "A serial port whose driver switches the direction of RS-485 where it can.",
               .options = {"baud", "echo"},
               .open = serial,
               .reopener = device_reopener(&reopen_serial, roots)});
    links.add({.name = "pty",
               .form = "pty:DEVICE",
               .says = "A pseudo terminal of a simulator; baud is what its devices see.",
               .options = {"baud", "echo"},
               .open = serial,
               .reopener = device_reopener(&reopen_serial, roots)});
    links.add({.name = "tcp",
               .form = "tcp://HOST:PORT",
               .says = "A box from Ethernet to RS-485; baud tells the rate that is set on it.",
               .options = {"baud", "echo"},
               .open = opener<ByteLink>(&open_tcp),
               .reopener = &reopen_tcp});
    links.add({.name = "slcan",
               .form = "slcan:DEVICE?bitrate=RATE",
               .says = "A CAN adapter that speaks SLCAN; bitrate is that of CAN, baud that of the port.",
               .options = {"bitrate", "baud"},
               .open = opener<CanLink>(&open_slcan),
               .reopener = device_reopener(&reopen_slcan, roots)});
    links.add({.name = "can",
               .form = "can:INTERFACE",
               .says = "A CAN interface of Linux (SocketCAN); ids=141-160,280 hears only these identifiers.",
               .options = {"bitrate", "ids"},
               .open = opener<CanLink>(&open_socketcan)});
    return links;
}

void Links::add(Scheme scheme)
{
    schemes_.push_back(std::move(scheme));
}

std::expected<std::pair<Uri, const Scheme*>, Error> Links::find(std::string_view uri) const
{
    auto parsed = parse_uri(uri);
    if (!parsed)
        return std::unexpected(parsed.error());
    const auto scheme = std::ranges::find(schemes_, parsed->scheme, &Scheme::name);
    if (scheme == schemes_.end())
        return refuse_scheme(*parsed, schemes_);
    for (const auto& [name, value] : parsed->options)
        if (std::ranges::find(scheme->options, name) == scheme->options.end())
            return refuse_option(name, *scheme);
    return std::pair{std::move(*parsed), &*scheme};
}

std::expected<AnyLink, Error> Links::open(std::string_view uri, Clock& clock) const
{
    const auto found = find(uri);
    return found ? found->second->open(found->first, clock) : std::unexpected(found.error());
}

Reopen Links::reopener(std::string_view uri, Clock& clock) const
{
    const auto found = find(uri);
    if (!found)
        return [error = found.error()] { return std::unexpected(error); };
    const auto& [parsed, scheme] = *found;
    if (scheme->reopener)
        return scheme->reopener(parsed, clock);
    return [open = scheme->open, again = parsed, &clock] { return open(again, clock); };
}

} // namespace sinew::link
