#include "apps/cli/bus_target.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/listener.hpp"
#include "apps/cli/sim_control.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/record/file.hpp"
#include "sinew/record/tap.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <set>
#include <sys/socket.h>

namespace sinew::cli {
namespace {

using record::Captured;
using wire::Direction;

// ---- what is shown ----

struct Filter {
    std::set<int> ids;
    std::set<std::string, std::less<>> messages;
    bool errors = false;

    bool passes(const Heard& heard) const
    {
        const auto& readings = heard.decoded.readings;
        const bool id = ids.empty() || (!readings.empty() && ids.contains(readings.front().id));
        const bool message =
            messages.empty() || (!readings.empty() && messages.contains(readings.front().message->name()));
        return id && message && (!errors || heard.is_error());
    }
};

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

std::string_view arrow(std::optional<Direction> direction)
{
    return !direction ? "--" : *direction == Direction::request ? "->" : "<-";
}

std::string_view to_word(Heard::Side side)
{
    constexpr std::string_view words[] = {"unknown", "capture", "frame", "order"};
    return words[static_cast<std::size_t>(side)];
}

std::string bytes_text(const Heard& heard)
{
    const auto& one = heard.decoded;
    const auto hex = to_hex(one.bytes);
    return heard.kind == Captured::Kind::bytes ? hex : fmt::format("{:03X}#{}", one.frame.can_id, hex);
}

/// How frames are shown, and how many there were.
class Screen
{
public:
    Screen(const Words& words, Filter filter)
        : filter_(std::move(filter)), json_(words.json()), absolute_(words.has("--absolute"))
    {
    }

    void show(const Heard& heard)
    {
        first_ = first_.value_or(heard.at);
        last_ = std::max(last_.value_or(heard.at), heard.at);
        ++frames_;
        errors_ += heard.is_error();
        if (!filter_.passes(heard))
            return;
        ++shown_;
        if (json_)
            print_line(to_json(heard));
        else
            print_text(heard);
    }
    std::uint64_t shown() const { return shown_; }
    void summary() const
    {
        const Duration time = first_ ? *last_ - *first_ : Duration{};
        fmt::print(stderr, "{} {}, {} with errors, in {:.3f} s\n", frames_, frames_ == 1 ? "frame" : "frames", errors_,
                   seconds(time));
    }

private:
    Json to_json(const Heard& heard) const
    {
        const auto& one = heard.decoded;
        Json out = Json::object(
            {{"time_s", seconds(heard.at - *first_)},
             {"unix_s", seconds(heard.at.time_since_epoch())},
             {"bus", heard.bus},
             {"direction",
              heard.direction ? Json(*heard.direction == Direction::request ? "request" : "reply") : Json()},
             {"direction_by", to_word(heard.side)},
             {"family", one.family != nullptr ? Json(one.family->name) : Json()},
             {"bytes", to_hex(one.bytes)}});
        if (heard.kind != Captured::Kind::bytes)
            out.set("can_id", one.frame.can_id);
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

    void print_text(const Heard& heard) const
    {
        const auto& one = heard.decoded;
        std::string line = absolute_ ? time_of_day(heard.at) : fmt::format("{:12.6f}", seconds(heard.at - *first_));
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
        fmt::print("{}\n", line);
        std::fflush(stdout);
    }

    Filter filter_;
    bool json_, absolute_;
    std::optional<record::Time> first_, last_;
    std::uint64_t frames_ = 0, errors_ = 0, shown_ = 0;
};

// ---- where it comes from ----

/// Somewhere frames come from. None of them sends anything.
class Source
{
public:
    virtual ~Source() = default;
    /// What has come by `until`, or earlier if something has; nothing when nothing came. `over` afterwards: it is over.
    virtual std::expected<std::optional<Captured>, Error> next(Duration patience) = 0;
    bool over = false;
};

class Replay final : public Source
{
public:
    explicit Replay(record::FileReader file) : file_(std::move(file)) {}
    std::expected<std::optional<Captured>, Error> next(Duration) override
    {
        auto one = file_.next();
        over = one && !*one;
        return one;
    }

private:
    record::FileReader file_;
};

/// A link that is only read.
class Listening final : public Source
{
public:
    Listening(std::unique_ptr<Session> session, link::AnyLink link, std::string name)
        : session_(std::move(session)), link_(std::move(link)), name_(std::move(name)),
          zero_(record::time_of_day_zero(session_->clock()))
    {
    }

    std::expected<std::optional<Captured>, Error> next(Duration patience) override
    {
        auto one = read();
        if (!one || *one)
            return one;
        const link::Handle handle{std::visit([](const auto& link) { return link->handle(); }, link_)};
        session_->clock().wait({&handle, 1}, session_->clock().now() + patience);
        return read();
    }

private:
    std::expected<std::optional<Captured>, Error> read()
    {
        if (auto* bytes = std::get_if<std::unique_ptr<link::ByteLink>>(&link_)) {
            std::array<std::uint8_t, 256> buffer;
            const auto got = (*bytes)->read(buffer);
            if (!got)
                return std::unexpected(got.error());
            if (got->count == 0)
                return std::nullopt;
            return Captured{.at = zero_ + got->at.time_since_epoch(),
                            .bus = name_,
                            .bytes = {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(got->count)}};
        }
        wire::Frame frame;
        const auto got = std::get<std::unique_ptr<link::CanLink>>(link_)->read({&frame, 1});
        if (!got)
            return std::unexpected(got.error());
        if (got->count == 0)
            return std::nullopt;
        return Captured{
            .at = zero_ + got->at.time_since_epoch(), .bus = name_, .kind = Captured::Kind::can, .frame = frame};
    }

    std::unique_ptr<Session> session_; // goes after its link
    link::AnyLink link_;
    std::string name_;
    record::Time zero_;
};

/// A bus of a simulator that runs elsewhere on this machine.
class Simulated final : public Source
{
public:
    explicit Simulated(link::Fd fd) : fd_(std::move(fd)) {}

    std::expected<std::optional<Captured>, Error> next(Duration patience) override
    {
        auto one = reader_.next();
        if (!one || *one)
            return one;
        const link::Handle handle{fd_.get()};
        clock_.wait({&handle, 1}, clock_.now() + patience);
        std::array<std::uint8_t, 64 * 1024> piece;
        const auto size = ::recv(fd_.get(), piece.data(), piece.size(), MSG_DONTWAIT);
        over = size == 0;
        if (size > 0)
            reader_.feed(std::span(piece).first(static_cast<std::size_t>(size)));
        return reader_.next();
    }

private:
    link::Fd fd_;
    link::RealClock clock_;
    record::PcapngReader reader_;
};

std::expected<std::unique_ptr<Source>, Error> open_source(const Words& words, const BusTarget& target)
{
    if (const auto path = words.text("--replay")) {
        auto file = record::FileReader::open(*path);
        if (!file)
            return std::unexpected(file.error());
        return std::make_unique<Replay>(std::move(*file));
    }
    const auto uri = link::parse_uri(target.link);
    if (!uri)
        return std::unexpected(uri.error());
    catch_interrupts();
    if (uri->scheme == "sim") {
        auto fd = sniff_simulator(uri->target, uri->fragment);
        if (!fd)
            return std::unexpected(fd.error());
        return std::make_unique<Simulated>(std::move(*fd));
    }
    auto session = std::make_unique<Session>();
    auto link = session->open(target.link);
    if (!link)
        return std::unexpected(link.error());
    return std::make_unique<Listening>(std::move(session), std::move(*link), target.name);
}

/// What the words say of the bus; of a replay only the family and the robot file's devices.
std::expected<BusTarget, Error> target_of(const Words& words)
{
    if (!words.has("--replay")) {
        if (!words.has("BUS"))
            return fail(Errc::bad_argument, "which bus? Name a link, a bus with --robot, or --replay FILE");
        Words without_ids; // --id is a filter here
        for (const auto* name : {"BUS", "--robot", "--link", "--family", "--model", "--profile"})
            for (const auto& value : words.all(name))
                without_ids.add(name, value);
        return bus_target(without_ids);
    }
    if (words.has("BUS"))
        return fail(Errc::bad_argument, "a bus and --replay exclude each other");
    BusTarget out;
    if (const auto name = words.text("--family")) {
        const auto family = family_named(*name);
        if (!family)
            return std::unexpected(family.error());
        out.family = *family;
    }
    if (const auto path = words.text("--robot")) {
        auto devices = devices_in(*path);
        if (!devices)
            return std::unexpected(devices.error());
        out.devices = std::move(*devices);
    }
    return out;
}

std::expected<std::optional<record::FileWriter>, Error> file_for(const Words& words)
{
    const auto path = words.text("--write");
    if (!path)
        return std::nullopt;
    if (words.text("--replay") == path)
        return fail(Errc::bad_argument, "a recording cannot be written over while it is read");
    auto file = record::FileWriter::create(*path);
    if (!file)
        return std::unexpected(file.error());
    return std::optional(std::move(*file));
}

Outcome listen(Source& source, Listener& listener, Screen& screen, record::FileWriter* file,
               std::optional<Duration> time, std::uint64_t count)
{
    const link::RealClock clock;
    const TimePoint end = time ? clock.now() + *time : TimePoint::max();
    const auto use = [&](const Heard& heard) {
        if (screen.shown() < count)
            screen.show(heard);
    };
    int code = exit_done;
    while (!interrupted() && !source.over && screen.shown() < count && clock.now() < end) {
        const auto one = source.next(std::min<Duration>(Listener::silence, end - clock.now()));
        if (!one && one.error().code != Errc::bad_file)
            return std::unexpected(one.error());
        if (!one) {
            // What can be read behind a damaged place of a recording is read.
            fmt::print(stderr, "sinew: {}\n", to_sentence(one.error()));
            code = exit_code(one.error().code);
            continue;
        }
        if (!*one) {
            listener.fall_silent(use);
            if (auto flushed = file != nullptr ? file->flush() : std::expected<void, Error>{}; !flushed)
                return std::unexpected(flushed.error());
            continue;
        }
        if (auto added = file != nullptr ? file->add(**one) : std::expected<void, Error>{}; !added)
            return std::unexpected(added.error());
        listener.hear(**one, use);
    }
    listener.fall_silent(use);
    if (auto flushed = file != nullptr ? file->flush() : std::expected<void, Error>{}; !flushed)
        return std::unexpected(flushed.error());
    return code;
}

Outcome run(const Words& words)
{
    const auto time = words.duration("--for");
    if (!time)
        return std::unexpected(time.error());
    const auto count = words.number("--count", 1, std::numeric_limits<std::int64_t>::max());
    if (!count)
        return std::unexpected(count.error());
    auto target = target_of(words);
    if (!target)
        return std::unexpected(target.error());
    auto filter = filter_from(words, target->family);
    if (!filter)
        return std::unexpected(filter.error());
    auto listener = Listener::make({.family = target->family,
                                    .profile = words.text("--profile").value_or(""),
                                    .model = words.text("--model").value_or("")},
                                   std::move(target->devices));
    if (!listener)
        return std::unexpected(listener.error());
    const auto source = open_source(words, *target);
    if (!source)
        return std::unexpected(source.error());
    auto file = file_for(words);
    if (!file)
        return std::unexpected(file.error());
    Screen screen(words, std::move(*filter));
    const auto outcome = listen(**source, *listener, screen, *file ? &**file : nullptr, *time,
                                *count ? static_cast<std::uint64_t>(**count) : ~std::uint64_t{0});
    screen.summary();
    return outcome;
}

} // namespace

Verb sniff_verb()
{
    return {
        .name = "sniff",
        .says = "Show decoded traffic of a bus as it passes, until Ctrl-C. It only listens.",
        .arguments = {{bus_argument.name, bus_argument.says, false}},
        .options = {{"--replay", "FILE", "read a recording instead: a candump log or pcapng; - is stdin"},
                    {"--write", "FILE", "keep everything: .log (candump, CAN only) or .pcapng (Wireshark)"},
                    {"--id", "N", "show this id only; may be given more than once", true},
                    {"--message", "MESSAGE", "show this message only; may be given more than once", true},
                    {"--errors", "", "show only what is wrong or was discarded"},
                    {"--absolute", "", "the time of day (UTC) and not the time since the first frame"},
                    {"--for", "TIME", "end after this time, such as 5s"},
                    {"--count", "N", "end after so many lines"},
                    robot_option,
                    link_option,
                    {"--family", "F", "sam, nuri or rmd; guessed where it is not given"},
                    model_option,
                    profile_option,
                    {"--json", "", "print one object per frame and line"}},
        .examples = {{"sinew sniff slcan:/dev/ttyACM0", "a CAN bus"},
                     {"sinew sniff serial:/dev/ttyUSB1?baud=1500000 --family sam --errors", "a second adapter"},
                     {"sinew sniff sim:robots/demo.toml#left", "a bus of the sinew sim that runs elsewhere"},
                     {"sinew sniff --replay run.pcapng --id 3", "a recording"},
                     {"sinew sniff --replay run.log --write run.pcapng >/dev/null", "for Wireshark"}},
        .run = run,
        .more =
            "-> was sent by the host, <- by a device. Where a line does not tell, the frame does, else the order: an "
            "answer follows its request. A port is opened by one program at a time, so listening to a serial line "
            "takes an adapter of its own."};
}

} // namespace sinew::cli
