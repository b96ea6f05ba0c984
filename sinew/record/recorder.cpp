#include "sinew/record/recorder.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <type_traits>

namespace sinew::record {
namespace {

constexpr auto write_period = std::chrono::milliseconds(50);
constexpr std::uint64_t chunk_ns = 1'000'000'000;

static_assert(std::is_trivially_copyable_v<actuator::State> && std::is_trivially_copyable_v<actuator::Command>);

template <class T>
std::span<const std::byte> bytes_in(const T& value)
{
    return std::as_bytes(std::span(&value, 1));
}

template <class T>
T copy_of(std::span<const std::byte> bytes)
{
    T out;
    std::memcpy(&out, bytes.data(), sizeof out);
    return out;
}

constexpr std::string_view level_words[] = {"info", "warning", "error"};

} // namespace

/// What stands in the ring before the bytes of an entry.
struct Recorder::Entry {
    Topic topic{};
    std::uint8_t word = 0; ///< direction of a frame, level of an event
    std::uint8_t verdict = 0;
    std::uint16_t which = 0; ///< bus or joint; of an event the length of its name
    std::uint32_t can_id = 0;
    std::int64_t at_ns = 0;
};

std::expected<std::unique_ptr<Recorder>, Error> Recorder::create(const std::filesystem::path& path, Settings settings)
{
    auto file = WholeFile::create(path);
    if (!file)
        return std::unexpected(file.error());
    std::unique_ptr<Recorder> out(new Recorder(std::move(*file), settings));
    out->writer_.add(mcap::Metadata{.name = "sinew", .pairs = {{"time", settings.zero == Time{} ? "virtual" : "utc"}}});
    out->events_.channel = [&] {
        auto channel = event_channel();
        channel.schema_id = out->schema(Topic::event);
        return out->writer_.add_channel(std::move(channel));
    }();
    if (auto written = out->write(); !written)
        return std::unexpected(written.error());
    return out;
}

Recorder::Recorder(WholeFile file, Settings settings)
    : ring_(settings.ring_bytes), file_(std::move(file)), zero_(settings.zero)
{
}

Recorder::~Recorder()
{
    (void)finish();
}

std::uint16_t Recorder::schema(Topic topic)
{
    auto& known = schemas_[static_cast<std::size_t>(topic)];
    if (known == 0)
        known = writer_.add_schema(schema_of(topic));
    return known;
}

Recorder::Bus Recorder::add_bus(const BusInfo& bus)
{
    auto channel = channel_of(bus);
    channel.schema_id = schema(Topic::frame);
    buses_.push_back({.channel = writer_.add_channel(std::move(channel)), .can = bus.can});
    return static_cast<Bus>(buses_.size() - 1);
}

Recorder::Joint Recorder::add_joint(const JointInfo& joint)
{
    for (const auto topic : {Topic::state, Topic::command}) {
        auto channel = channel_of(joint, topic);
        channel.schema_id = schema(topic);
        (topic == Topic::state ? states_ : commands_).push_back({.channel = writer_.add_channel(std::move(channel))});
    }
    return static_cast<Joint>(states_.size() - 1);
}

std::expected<void, Error> Recorder::attach(std::string name, std::string media_type, std::string data)
{
    const auto now = static_cast<std::uint64_t>(std::max<std::int64_t>(zero_.time_since_epoch().count(), 0));
    writer_.attach({.log_time_ns = now,
                    .create_time_ns = now,
                    .name = std::move(name),
                    .media_type = std::move(media_type),
                    .data = std::move(data)});
    return write();
}

// ---- in the loop ----

bool Recorder::push(const Entry& entry, std::span<const std::byte> first, std::span<const std::byte> second) noexcept
{
    std::byte* place = ring_.reserve(sizeof entry + first.size() + second.size());
    if (place == nullptr) {
        dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
    }
    std::memcpy(place, &entry, sizeof entry);
    if (!first.empty())
        std::memcpy(place + sizeof entry, first.data(), first.size());
    if (!second.empty())
        std::memcpy(place + sizeof entry + first.size(), second.data(), second.size());
    ring_.commit();
    return true;
}

bool Recorder::frame(Bus bus, const bus::Tapped& tapped) noexcept
{
    return push({.topic = Topic::frame,
                 .word = static_cast<std::uint8_t>(tapped.direction),
                 .verdict = static_cast<std::uint8_t>(tapped.verdict),
                 .which = static_cast<std::uint16_t>(bus),
                 .can_id = tapped.can_id,
                 .at_ns = tapped.at.time_since_epoch().count()},
                std::as_bytes(tapped.bytes), {});
}

bool Recorder::state(Joint joint, const actuator::State& state) noexcept
{
    return push({.topic = Topic::state,
                 .which = static_cast<std::uint16_t>(joint),
                 .at_ns = state.at.time_since_epoch().count()},
                bytes_in(state), {});
}

bool Recorder::command(Joint joint, TimePoint at, const actuator::Command& command) noexcept
{
    return push(
        {.topic = Topic::command, .which = static_cast<std::uint16_t>(joint), .at_ns = at.time_since_epoch().count()},
        bytes_in(command), {});
}

bool Recorder::event(TimePoint at, Level level, std::string_view name, std::string_view text) noexcept
{
    name = name.substr(0, 255);
    return push({.topic = Topic::event,
                 .word = static_cast<std::uint8_t>(level),
                 .which = static_cast<std::uint16_t>(name.size()),
                 .at_ns = at.time_since_epoch().count()},
                std::as_bytes(std::span(name)), std::as_bytes(std::span(text)));
}

// ---- outside of it ----

std::uint64_t Recorder::time_ns(std::int64_t at_ns) const
{
    return static_cast<std::uint64_t>(std::max<std::int64_t>(zero_.time_since_epoch().count() + at_ns, 0));
}

void Recorder::take(std::span<const std::byte> bytes)
{
    const auto entry = copy_of<Entry>(bytes);
    bytes = bytes.subspan(sizeof entry);
    const std::span raw(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    const std::uint64_t at = time_ns(entry.at_ns);
    last_ns_ = std::max(last_ns_, at);
    if (!writer_.has_open_chunk())
        chunk_began_ns_ = at;
    const auto add = [&](Known& known, auto&& fill) {
        writer_.add(known.channel, {.sequence = known.sequence++, .log_time_ns = at, .publish_time_ns = at}, fill);
    };
    switch (entry.topic) {
    case Topic::frame: {
        Known& known = buses_[entry.which];
        const bus::Tapped tapped{.direction = static_cast<wire::Direction>(entry.word),
                                 .bytes = raw,
                                 .can_id = entry.can_id,
                                 .verdict = static_cast<bus::Verdict>(entry.verdict)};
        add(known, [&](std::string& out) { put_frame(out, tapped, known.can); });
        break;
    }
    case Topic::state: {
        Known& known = states_[entry.which];
        scratch_.clear();
        if (put_state(scratch_, copy_of<actuator::State>(bytes), known.told))
            add(known, [&](std::string& out) { out += scratch_; });
        break;
    }
    case Topic::command:
        add(commands_[entry.which], [&](std::string& out) { put_command(out, copy_of<actuator::Command>(bytes)); });
        break;
    case Topic::event:
        add(events_, [&](std::string& out) {
            JsonWriter json(out);
            json.text("level", level_words[entry.word]);
            json.text("name", text_of(raw.first(entry.which)));
            json.text("text", text_of(raw.subspan(entry.which)));
        });
        break;
    case Topic::other:
        break;
    }
}

/// A gap must be seen by whoever reads the recording.
void Recorder::tell_dropped()
{
    const auto dropped = this->dropped();
    if (dropped == told_dropped_)
        return;
    const auto text = fmt::format("{} entries were lost because the ring was full", dropped - told_dropped_);
    told_dropped_ = dropped;
    writer_.add(events_.channel, {.sequence = events_.sequence++, .log_time_ns = last_ns_, .publish_time_ns = last_ns_},
                [&](std::string& out) {
                    JsonWriter json(out);
                    json.text("level", "warning");
                    json.text("name", "dropped");
                    json.text("text", text);
                });
}

std::expected<void, Error> Recorder::write()
{
    if (trouble_)
        return std::unexpected(*trouble_);
    if (auto appended = file_.append(writer_.pending()); !appended) {
        trouble_ = appended.error();
        failed_ = true;
        writer_.drop_pending();
        return appended;
    }
    writer_.written();
    return {};
}

std::expected<void, Error> Recorder::drain()
{
    for (auto bytes = ring_.front(); bytes.data() != nullptr; bytes = ring_.front()) {
        if (!trouble_)
            take(bytes);
        ring_.pop();
        if (!writer_.pending().empty())
            (void)write(); // the error stays, and is told below
    }
    if (!trouble_)
        tell_dropped();
    if (writer_.has_open_chunk() && last_ns_ - chunk_began_ns_ >= chunk_ns)
        writer_.close_chunk();
    return write();
}

std::expected<void, Error> Recorder::flush()
{
    (void)drain(); // the error stays
    writer_.close_chunk();
    return write();
}

void Recorder::run_in_thread()
{
    thread_ = std::thread([this] {
        std::unique_lock lock(stop_mutex_);
        while (!stop_.wait_for(lock, write_period, [this] { return stopping_; }))
            (void)drain(); // `finish` tells it
    });
}

std::expected<void, Error> Recorder::finish()
{
    if (thread_.joinable()) {
        {
            const std::scoped_lock lock(stop_mutex_);
            stopping_ = true;
        }
        stop_.notify_all();
        thread_.join();
    }
    if (std::exchange(finished_, true))
        return trouble_ ? std::unexpected(*trouble_) : std::expected<void, Error>{};
    (void)flush(); // the error stays
    if (trouble_) {
        // What did not fit is gone; the end may fit in its place.
        writer_.close_chunk();
        writer_.drop_pending();
    }
    writer_.finish();
    auto ended = file_.append(writer_.pending());
    return trouble_ ? std::unexpected(*trouble_) : ended;
}

} // namespace sinew::record
