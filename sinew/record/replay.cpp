#include "sinew/record/replay.hpp"

#include "sinew/link/virtual.hpp"
#include "sinew/record/answers.hpp"
#include "sinew/record/file.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::record {
namespace {

/// Time that moves in `wait` alone: to what arrives next on a link, or to the deadline.
class ReplayClock final : public link::Clock
{
public:
    class Line
    {
    public:
        virtual ~Line() = default;
        virtual std::optional<TimePoint> next_arrival() const = 0;
    };

    void begin_at(TimePoint at) { now_ = at; }
    void watch(Line& line) { lines_.push_back(&line); }
    TimePoint now() const override { return now_; }
    void wait(std::span<const link::Handle>, TimePoint deadline) override
    {
        TimePoint next = deadline;
        for (const Line* line : lines_)
            next = std::min(next, line->next_arrival().value_or(deadline));
        if (next != TimePoint::max())
            now_ = std::max(now_, next);
    }

private:
    TimePoint now_{};
    std::vector<Line*> lines_;
};

/// One bus of a recording: the far end of the links that lead to it, of which the last one counts.
class Line final : public ReplayClock::Line, public link::ByteSink, public link::CanSink
{
public:
    explicit Line(ReplayClock& clock) : clock_(clock) {}

    Answers answers;

    link::AnyLink open(bool loop)
    {
        constexpr std::uint32_t rate = 0; // not known; the recorded times have it in them
        loop_ = loop;
        answers.rewind();
        if (answers.is_can()) {
            auto link = std::make_unique<link::VirtualCanLink>(clock_, static_cast<link::CanSink&>(*this), rate);
            can_ = link.get();
            return std::unique_ptr<link::CanLink>(std::move(link));
        }
        auto link = std::make_unique<link::VirtualByteLink>(clock_, static_cast<link::ByteSink&>(*this), rate);
        bytes_ = link.get();
        return std::unique_ptr<link::ByteLink>(std::move(link));
    }

    std::optional<TimePoint> next_arrival() const override
    {
        return can_ != nullptr ? can_->next_arrival() : bytes_ != nullptr ? bytes_->next_arrival() : std::nullopt;
    }
    void on_write(std::span<const std::uint8_t> bytes, std::uint32_t) override
    {
        for (const auto& reply : answers.next(0, bytes, loop_))
            bytes_->deliver(reply.said.bytes, clock_.now() + reply.after);
    }
    void on_write(std::span<const wire::Frame> frames, std::uint32_t) override
    {
        for (const auto& frame : frames)
            for (const auto& reply : answers.next(frame.can_id, frame.bytes(), loop_))
                can_->deliver({&reply.said.frame, 1}, clock_.now() + reply.after);
    }
    void on_close() override
    {
        can_ = nullptr;
        bytes_ = nullptr;
    }

private:
    ReplayClock& clock_;
    link::VirtualByteLink* bytes_ = nullptr;
    link::VirtualCanLink* can_ = nullptr;
    bool loop_ = false;
};

} // namespace

/// A recording with its time.
class Replays::File
{
public:
    static std::expected<std::unique_ptr<File>, Error> read(const std::string& path)
    {
        auto reader = FileReader::open(path);
        if (!reader)
            return std::unexpected(reader.error());
        auto out = std::make_unique<File>();
        out->path_ = path;
        std::optional<Error> problem;
        for (bool first = true;;) {
            const auto one = reader->next();
            if (!one) { // what was cut off is used as far as it goes
                problem = problem ? problem : one.error();
                continue;
            }
            if (!*one)
                break;
            if (std::exchange(first, false))
                out->clock.begin_at(TimePoint{(*one)->at.time_since_epoch()});
            out->line((*one)->bus).answers.add(**one);
        }
        if (out->lines_.empty())
            return problem ? std::unexpected(*problem)
                           : fail(Errc::bad_file, fmt::format("{} has no frames that could be replayed", path));
        return out;
    }

    std::expected<link::AnyLink, Error> open(const std::string& bus, bool loop)
    {
        const auto found = bus.empty() && lines_.size() == 1 ? lines_.begin() : lines_.find(bus);
        if (found == lines_.end()) {
            std::vector<std::string_view> names;
            for (const auto& [name, line] : lines_)
                names.push_back(name);
            return fail(Errc::link_not_found,
                        fmt::format("{} has no bus '{}'; it has {}", path_, bus, fmt::join(names, ", ")));
        }
        if (!found->second->answers.has_requests())
            return fail(Errc::bad_file,
                        fmt::format("{} does not tell who sent what on {}, so nothing can be replayed: it was "
                                    "recorded by somebody who only listened",
                                    path_, found->first.empty() ? "its bus" : found->first));
        return found->second->open(loop);
    }

    std::uint64_t given() const
    {
        std::uint64_t out = 0;
        for (const auto& [name, line] : lines_)
            out += line->answers.given();
        return out;
    }

    ReplayClock clock;

private:
    Line& line(const std::string& bus)
    {
        auto& known = lines_[bus];
        if (!known) {
            known = std::make_unique<Line>(clock);
            clock.watch(*known);
        }
        return *known;
    }

    std::string path_;
    std::map<std::string, std::unique_ptr<Line>> lines_;
};

Replays::Replays() = default;
Replays::~Replays() = default;

std::expected<Replays::File*, Error> Replays::file(const std::string& path)
{
    auto& known = files_[path];
    if (!known) {
        auto read = File::read(path);
        if (!read)
            return std::unexpected(read.error());
        known = std::move(*read);
    }
    return known.get();
}

std::expected<link::AnyLink, Error> Replays::open(const link::Uri& uri, link::Clock& clock)
{
    const auto loop = uri.option("loop").value_or("off");
    if (loop != "on" && loop != "off")
        return fail(Errc::bad_uri, fmt::format("loop={} in '{}': it is on or off", loop, to_string(uri)));
    const auto found = file(uri.target);
    if (!found)
        return std::unexpected(found.error());
    if (&clock != &(*found)->clock)
        return fail(Errc::bad_argument,
                    fmt::format("'{}' has a time of its own and cannot be opened with another clock", to_string(uri)));
    return (*found)->open(uri.fragment, loop == "on");
}

std::expected<link::Clock*, Error> Replays::clock_for(std::string_view uri)
{
    const auto parsed = link::parse_uri(uri);
    if (!parsed)
        return std::unexpected(parsed.error());
    const auto found = file(parsed->target);
    if (!found)
        return std::unexpected(found.error());
    return &(*found)->clock;
}

std::uint64_t Replays::given() const
{
    std::uint64_t out = 0;
    for (const auto& [path, file] : files_)
        out += file->given();
    return out;
}

bool is_replay(std::string_view uri)
{
    const auto parsed = link::parse_uri(uri);
    return parsed && parsed->scheme == "replay";
}

void add(link::Links& links, Replays& replays)
{
    links.add({.name = "replay",
               .form = "replay:FILE#BUS",
               .says = "A bus of a recording whose devices answer as they did; loop=on to begin again at its end.",
               .options = {"loop"},
               .open = [&replays](const link::Uri& uri, link::Clock& clock) { return replays.open(uri, clock); }});
}

} // namespace sinew::record
