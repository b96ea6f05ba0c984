#pragma once
#include "sinew/link/echo.hpp"
#include "sinew/sim/wire/faults.hpp"
#include "tests/bus/rig.hpp"

#include <deque>
#include <utility>
#include <vector>

/// A serial wire, true to the byte time, that knows of every byte the host reads where it came from. So a test can say
/// with certainty whose data a call returned, also where the bytes themselves do not tell.
namespace sinew::tests {

/// An answer that a device gave.
struct Given {
    int id = 0;
    const wire::MessageInfo* message = nullptr;
    bool by_mistake = false; ///< the request had been damaged into one that is in order
    TimePoint heard_at{};
    wire::Frame frame{};
};

/// A byte on its way to the host.
struct Coming {
    TimePoint at{};
    std::uint8_t byte = 0;
    std::uint32_t given = 0; ///< number of the answer that it is part of; 0: noise, or an echo
    std::uint8_t index = 0;  ///< in that answer
    bool is_damaged = false;
};

struct TracedFaults {
    sim::WireFaults bytes{};  ///< of both directions; `delay_reply` of a whole answer, by up to `reply_delay`
    double cut_cable = 0.0;   ///< a frame of the host, and what it brings, is lost together with those of 20 ms
    double dead_device = 0.0; ///< the device that is asked is off for 100 ms
    double hang_up = 0.0;     ///< the link is lost with what it holds, and comes back
    bool echo = false;        ///< the host hears itself; its link swallows that
    /// With each frame of the host another master asks one of `others`, some time in the 20 ms that follow.
    double other_master = 0.0;
    std::vector<wire::Frame> others{};
};

class TracedWire final : public Port
{
public:
    /// What a device answers; nothing: it is silent.
    using Answer =
        std::function<std::optional<wire::Frame>(const wire::MessageInfo& message, int id, std::uint32_t number)>;

    TracedWire(WireClock& clock, const wire::Protocol& protocol, const wire::Profile& profile, std::uint32_t bit_rate,
               Duration response, bus::Settings settings, TracedFaults faults, Answer answer)
        : clock_(clock), protocol_(protocol), profile_(profile), bit_rate_(bit_rate), response_(response),
          faults_(std::move(faults)), answer_(std::move(answer))
    {
        clock.watch(*this);
        bus.emplace("traced", plug_in(), clock, protocol, settings);
        bus->set_reopen([this]() -> std::expected<link::AnyLink, Error> { return plug_in(); }, Duration(1));
        given.emplace_back();
    }
    void seed(std::uint64_t value) { dice_.seed(value); }

    TimePoint next_event() const override { return hearing_.empty() ? TimePoint::max() : hearing_.front().at; }
    void run_until(TimePoint until) override
    {
        while (!hearing_.empty() && hearing_.front().at <= until) {
            const Hearing heard = hearing_.front();
            hearing_.pop_front();
            hear(heard);
        }
    }
    std::optional<TimePoint> next_arrival() const override
    {
        return coming_.empty() ? std::nullopt : std::optional(coming_.front().at);
    }

    std::vector<Coming> read; ///< what the host has read; the test clears it
    std::vector<Given> given; ///< from number 1 on
    std::optional<bus::Bus> bus;

private:
    class Link final : public link::ByteLink
    {
    public:
        explicit Link(TracedWire& wire) : wire_(wire) {}
        std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
        {
            if (wire_.is_gone_)
                return std::unexpected(Error{.code = Errc::link_lost});
            wire_.send(bytes);
            return bytes.size();
        }
        std::expected<link::Arrival, Error> read(std::span<std::uint8_t> into) override
        {
            if (wire_.is_gone_)
                return std::unexpected(Error{.code = Errc::link_lost});
            return wire_.take(into);
        }
        int handle() const override { return -1; }
        link::LinkState state() const override { return {.open = !wire_.is_gone_, .bit_rate = wire_.bit_rate_}; }
        std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return rate; }

    private:
        TracedWire& wire_;
    };

    /// What the devices hear of a frame of the host, and what it was.
    struct Hearing {
        TimePoint at{};
        std::array<std::uint8_t, 2 * wire::Frame::capacity> bytes{};
        std::size_t size = 0;
        wire::Frame sent{};
    };

    link::AnyLink plug_in()
    {
        is_gone_ = false;
        std::unique_ptr<link::ByteLink> link = std::make_unique<Link>(*this);
        if (faults_.echo)
            link = std::make_unique<link::EchoLink>(std::move(link), link::Echo::on, clock_);
        return link::AnyLink{std::move(link)};
    }

    Duration byte_time(std::size_t count) const { return bit_time(static_cast<std::int64_t>(10 * count), bit_rate_); }

    void send(std::span<const std::uint8_t> bytes)
    {
        const TimePoint start = std::max(clock_.now(), host_free_);
        host_free_ = start + byte_time(bytes.size());
        is_gone_ = is_gone_ || dice_.falls(faults_.hang_up);
        if (is_gone_)
            coming_.clear();
        if (dice_.falls(faults_.cut_cable))
            cut_until_ = start + std::chrono::milliseconds(20);
        Hearing heard{.at = host_free_};
        heard.sent.size = static_cast<std::uint8_t>(bytes.size());
        std::ranges::copy(bytes, heard.sent.data.begin());
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            if (faults_.echo)
                arrive({.at = start + byte_time(i + 1), .byte = bytes[i]});
            spoil(bytes[i], [&](std::uint8_t byte, bool, bool) { heard.bytes[heard.size++] = byte; });
        }
        if (host_free_ > cut_until_)
            hear_later(heard);
        if (dice_.falls(faults_.other_master))
            ask_as_other_master();
    }

    void hear_later(const Hearing& heard)
    {
        hearing_.insert(std::ranges::upper_bound(hearing_, heard.at, {}, &Hearing::at), heard);
    }

    void ask_as_other_master()
    {
        Hearing heard{.at = host_free_ + std::chrono::microseconds(dice_.pick(20'000)),
                      .sent = faults_.others[dice_.pick(static_cast<unsigned>(faults_.others.size()))]};
        heard.size = heard.sent.size;
        std::ranges::copy(heard.sent.data, heard.bytes.begin());
        hear_later(heard);
    }

    /// One byte through the faults: `pass(byte, is_damaged, is_noise)` for what comes out of it.
    template <class F>
    void spoil(std::uint8_t byte, F&& pass)
    {
        const bool flips = dice_.falls(faults_.bytes.flip_bit);
        if (flips)
            byte = static_cast<std::uint8_t>(byte ^ (1U << dice_.pick(8)));
        if (!dice_.falls(faults_.bytes.drop_byte))
            pass(byte, flips, false);
        if (dice_.falls(faults_.bytes.add_byte))
            pass(static_cast<std::uint8_t>(dice_.pick(256)), false, true);
    }

    void hear(const Hearing& heard)
    {
        std::size_t used = 0;
        while (used < heard.size) {
            const auto rest = std::span(heard.bytes).first(heard.size).subspan(used);
            const auto scan = protocol_.find_request(rest, true);
            used += scan.skip + scan.size;
            if (scan.size == 0)
                return;
            wire::Frame frame{.size = static_cast<std::uint8_t>(scan.size)};
            std::ranges::copy(rest.subspan(scan.skip, scan.size), frame.data.begin());
            respond(frame, frame != heard.sent, heard.at);
        }
    }

    void respond(const wire::Frame& request, bool by_mistake, TimePoint at)
    {
        const int id = protocol_.addressee(request);
        const auto* message = protocol_.identify(request, wire::Direction::request, profile_);
        if (id < 0 || id >= 256 || message == nullptr || at < dead_until_[static_cast<std::size_t>(id)])
            return;
        if (dice_.falls(faults_.dead_device)) {
            dead_until_[static_cast<std::size_t>(id)] = at + std::chrono::milliseconds(100);
            return;
        }
        const auto number = static_cast<std::uint32_t>(given.size());
        const auto frame = answer_(*message, id, number);
        if (!frame)
            return;
        given.push_back({id, message, by_mistake, at, *frame});
        TimePoint start = at + response_;
        if (dice_.falls(faults_.bytes.delay_reply))
            start += faults_.bytes.reply_delay * static_cast<int>(1 + dice_.pick(1000)) / 1000;
        std::size_t place = 0;
        for (std::uint8_t i = 0; i < frame->size; ++i)
            spoil(frame->data[i], [&](std::uint8_t byte, bool is_damaged, bool is_noise) {
                arrive({.at = start + byte_time(++place),
                        .byte = byte,
                        .given = is_noise ? 0 : number,
                        .index = i,
                        .is_damaged = is_damaged});
            });
    }

    void arrive(Coming coming)
    {
        if (coming.at <= cut_until_)
            return;
        auto place = std::ranges::upper_bound(coming_, coming.at, {}, &Coming::at);
        for (; place != coming_.begin() && std::prev(place)->at == coming.at; coming.at += Duration(1))
            place = std::ranges::upper_bound(coming_, coming.at + Duration(1), {}, &Coming::at);
        coming_.insert(place, coming);
    }

    link::Arrival take(std::span<std::uint8_t> into)
    {
        if (into.empty() || coming_.empty() || coming_.front().at > clock_.now())
            return {.count = 0, .at = clock_.now()};
        read.push_back(coming_.front());
        coming_.pop_front();
        into[0] = read.back().byte;
        return {.count = 1, .at = read.back().at, .more = !coming_.empty() && coming_.front().at <= clock_.now()};
    }

    WireClock& clock_;
    const wire::Protocol& protocol_;
    const wire::Profile& profile_;
    std::uint32_t bit_rate_;
    Duration response_;
    TracedFaults faults_;
    Answer answer_;
    sim::Dice dice_;
    bool is_gone_ = false;
    TimePoint host_free_{};
    TimePoint cut_until_{};
    std::array<TimePoint, 256> dead_until_{};
    std::deque<Hearing> hearing_;
    std::deque<Coming> coming_;
};

} // namespace sinew::tests
