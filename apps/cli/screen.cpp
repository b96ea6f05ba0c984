#include "apps/cli/screen.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/link/can_error.hpp"
#include "sinew/record/candump.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace sinew::cli {
namespace {

using record::Captured;
using wire::Direction;

std::string_view arrow(std::optional<Direction> direction)
{
    return !direction ? "--" : *direction == Direction::request ? "->" : "<-";
}

std::string_view to_word(Heard::Side side)
{
    constexpr std::string_view words[] = {"unknown", "capture", "frame", "order"};
    return words[static_cast<std::size_t>(side)];
}

Json words_of_error(const wire::Frame& error)
{
    Json out = Json::array();
    for (const auto& word : link::can_error_words(error))
        out.add(word);
    return out;
}

std::string bytes_text(const Heard& heard)
{
    const auto& one = heard.decoded;
    const auto hex = to_hex(one.bytes);
    if (heard.kind == Captured::Kind::can_error)
        return record::can_text({.kind = heard.kind, .frame = one.frame});
    return heard.kind == Captured::Kind::bytes ? hex : fmt::format("{:03X}#{}", one.frame.can_id, hex);
}

} // namespace

bool Filter::passes(const Heard& heard) const
{
    const auto& readings = heard.decoded.readings;
    const bool id = ids.empty() || (!readings.empty() && ids.contains(readings.front().id));
    const bool message = messages.empty() || (!readings.empty() && messages.contains(readings.front().message->name()));
    return id && message && (!errors || heard.is_error());
}

std::expected<Filter, Error> filter_from(const Words& words, const Family* only)
{
    Filter out{.errors = words.has("--errors")};
    for (const auto& word : words.all("--id")) {
        const auto id = to_integer(word);
        if (!id || *id < 0 || *id > 255)
            return fail(Errc::bad_argument, fmt::format("--id takes a number from 0 to 255, not '{}'", word));
        out.ids.insert(static_cast<int>(*id));
    }
    for (const auto& word : words.all("--message")) {
        std::vector<std::string_view> names;
        for (const auto* family : families())
            for (const auto* line : family->profiles)
                for (const auto* message : line->messages)
                    if (only == nullptr || only == family)
                        names.push_back(message->name());
        if (std::ranges::find(names, word) == names.end())
            return fail(Errc::unknown_name, fmt::format("there is no message '{}'{}", word, did_you_mean(word, names)));
        out.messages.insert(word);
    }
    return out;
}

std::string time_of_day(record::Time at)
{
    const auto day = std::chrono::floor<std::chrono::days>(at);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss time(std::chrono::floor<std::chrono::microseconds>(at - day));
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", static_cast<int>(date.year()),
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), time.hours().count(),
                       time.minutes().count(), time.seconds().count(), time.subseconds().count());
}

void Screen::see(record::Time at)
{
    first_ = first_.value_or(at);
    last_ = std::max(last_.value_or(at), at);
}

void Screen::show(const Heard& heard)
{
    see(heard.at);
    ++frames_;
    errors_ += heard.is_error();
    if (!filter_.passes(heard))
        return;
    ++shown_;
    if (json_) {
        print_line(to_json(heard));
    } else {
        fmt::print("{}\n", to_text(heard));
        std::fflush(stdout);
    }
}

void Screen::show(record::Time at, std::string_view text, Json json)
{
    see(at);
    ++shown_;
    if (json_) {
        json.set("time_s", seconds(at - *first_));
        json.set("unix_s", seconds(at.time_since_epoch()));
        print_line(json);
    } else {
        fmt::print("{}  {}\n", begin_text(at), text);
    }
}

void Screen::summary() const
{
    const Duration time = first_ ? *last_ - *first_ : Duration{};
    fmt::print(stderr, "{} {}, {} with errors, in {:.3f} s\n", frames_, frames_ == 1 ? "frame" : "frames", errors_,
               seconds(time));
}

std::string Screen::begin_text(record::Time at) const
{
    return absolute_ ? time_of_day(at) : fmt::format("{:12.6f}", seconds(at - *first_));
}

Json Screen::to_json(const Heard& heard) const
{
    const auto& one = heard.decoded;
    Json out = Json::object(
        {{"time_s", seconds(heard.at - *first_)},
         {"unix_s", seconds(heard.at.time_since_epoch())},
         {"bus", heard.bus},
         {"direction", heard.direction ? Json(*heard.direction == Direction::request ? "request" : "reply") : Json()},
         {"direction_by", to_word(heard.side)},
         {"family", one.family != nullptr ? Json(one.family->name) : Json()},
         {"bytes", to_hex(one.bytes)}});
    if (heard.kind != Captured::Kind::bytes)
        out.set("can_id", one.frame.can_id);
    if (heard.kind == Captured::Kind::can_error)
        out.set("can_error", words_of_error(one.frame));
    if (!one.readings.empty()) {
        const auto& reading = one.readings.front();
        out.set("message", reading.message->name());
        out.set("id", reading.id >= 0 ? Json(reading.id) : Json());
        out.set("values", cli::to_json(reading.values));
    }
    if (one.error)
        out.set("error",
                Json::object({{"code", sinew::to_word(one.error->code)}, {"sentence", to_sentence(*one.error)}}));
    if (!heard.discarded.empty())
        out.set("discarded", heard.discarded);
    return out;
}

std::string Screen::to_text(const Heard& heard) const
{
    const auto& one = heard.decoded;
    std::string line = begin_text(heard.at);
    if (!heard.bus.empty())
        line += "  " + heard.bus;
    line += fmt::format("  {} {}", arrow(heard.direction), bytes_text(heard));
    if (!one.readings.empty()) {
        const auto& reading = one.readings.front();
        line += "  " + describe(*reading.message, reading.direction, reading.id);
        std::string_view before = ": ";
        for (const auto& value : reading.values)
            line += fmt::format("{}{} {}", std::exchange(before, ", "), value.name, text(value));
    }
    if (one.error)
        line += "  " + bold("error: ") + to_sentence(*one.error);
    if (!heard.discarded.empty())
        line += "  " + bold("discarded: ") + heard.discarded;
    return line;
}

} // namespace sinew::cli
