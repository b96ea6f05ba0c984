#include "sinew/diagnosis/line.hpp"

#include "sinew/bus/predict.hpp"
#include "sinew/diagnosis/probes.hpp"
#include "sinew/link/echo.hpp"
#include "sinew/link/slcan.hpp"

#include <algorithm>

namespace sinew::diagnosis {
namespace {

template <class Link>
class Lent;

template <>
class Lent<link::ByteLink> final : public link::ByteLink
{
public:
    explicit Lent(link::ByteLink& link) : link_(link) {}
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override { return link_.write(bytes); }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t> into) override { return link_.read(into); }
    int handle() const override { return link_.handle(); }
    link::LinkState state() const override { return link_.state(); }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return link_.set_bit_rate(rate); }

private:
    link::ByteLink& link_;
};

template <>
class Lent<link::CanLink> final : public link::CanLink
{
public:
    explicit Lent(link::CanLink& link) : link_(link) {}
    std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) override
    {
        return link_.write(frames);
    }
    std::expected<link::Arrival, Error> read(std::span<wire::Frame> into) override { return link_.read(into); }
    int handle() const override { return link_.handle(); }
    link::LinkState state() const override { return link_.state(); }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return link_.set_bit_rate(rate); }

private:
    link::CanLink& link_;
};

link::AnyLink lend(link::AnyLink& link)
{
    return std::visit(
        []<class Link>(std::unique_ptr<Link>& l) -> link::AnyLink { return std::make_unique<Lent<Link>>(*l); }, link);
}

bool lost(const Error& error)
{
    return error.code == Errc::link_lost || error.code == Errc::link_failed;
}

constexpr bus::Settings settings(Duration wait)
{
    return {.margin_at_first = wait, .margin_least = wait, .late_max = {}, .read_retries = 0};
}

} // namespace

struct Line::Shared {
    link::AnyLink link;
};

Line::Line(link::AnyLink link, link::Clock& clock) : shared_(new Shared{std::move(link)}), clock_(clock) {}
Line::~Line() = default;

bool Line::can() const
{
    return std::holds_alternative<std::unique_ptr<link::CanLink>>(shared_->link);
}

link::LinkState Line::state() const
{
    return std::visit([](const auto& l) { return l->state(); }, shared_->link);
}

const link::AnyLink& Line::link() const
{
    return shared_->link;
}

std::expected<std::optional<std::uint8_t>, Error> Line::adapter_flags()
{
    const auto* can_link = std::get_if<std::unique_ptr<link::CanLink>>(&shared_->link);
    auto* adapter = can_link != nullptr ? dynamic_cast<link::SlcanLink*>(can_link->get()) : nullptr;
    if (adapter == nullptr)
        return std::nullopt;
    const link::FlagsQuestion question(*adapter, clock_.now());
    while (!question.is_over(*adapter, clock_.now()))
        if (const auto heard = listen(std::chrono::milliseconds{2}); !heard)
            return std::unexpected(heard.error());
    return question.is_answered(*adapter) ? std::optional(adapter->flags()) : std::nullopt;
}

std::expected<bool, Error> Line::set_bit_rate(std::uint32_t rate)
{
    if (rate == 0 || rate == bit_rate())
        return true;
    const auto set = std::visit([&](auto& l) { return l->set_bit_rate(rate); }, shared_->link);
    if (!set && lost(set.error()))
        return std::unexpected(set.error());
    return set.has_value();
}

void Line::swallow_echo()
{
    auto& bytes = std::get<std::unique_ptr<link::ByteLink>>(shared_->link);
    bytes = std::make_unique<link::EchoLink>(std::move(bytes), link::Echo::on, clock_);
}

std::optional<wire::Request> Line::safe_one(std::span<const wire::Request> ways)
{
    if (can())
        return ways.empty() ? std::nullopt : std::optional(ways.front());
    auto one = diagnosis::safe_one(ways, audience_, bit_rate());
    for (const auto byte : fillers())
        if (!one && send_filler(byte))
            one = diagnosis::safe_one(ways, audience_, bit_rate());
    return one;
}

/// False where it would harm somebody, or the link does not take it: the next question tells why.
bool Line::send_filler(std::uint8_t byte)
{
    const wire::Frame frame{.size = 1, .data = {byte}};
    if (!audience_.harmless(frame, bit_rate()))
        return false;
    const auto sent = std::get<std::unique_ptr<link::ByteLink>>(shared_->link)->write(frame.bytes());
    if (!sent || *sent == 0)
        return false;
    audience_.hear(frame, bit_rate());
    filled_until_ = std::max(clock_.now(), filled_until_) + bus::frame_time({.bit_rate = bit_rate()}, frame.size);
    return true;
}

std::unique_ptr<bus::Bus> Line::make_bus(const Family& family, Duration wait)
{
    return std::make_unique<bus::Bus>("diagnosis", lend(shared_->link), clock_, *family.protocol, settings(wait));
}

std::expected<Look, Error> Line::look(const wire::Request& request, const Family& family, Duration wait)
{
    const auto bus = make_bus(family, wait);
    Look out;
    bus->set_tap([&](const bus::Tapped& tapped) {
        constexpr std::size_t enough = 64;
        if (tapped.direction == wire::Direction::reply && out.heard.size() < enough)
            out.heard.insert(out.heard.end(), tapped.bytes.begin(), tapped.bytes.end());
    });
    wire::Request asked = request;
    asked.response_time = {};
    bus::Result result;
    bus::Bus* const one = bus.get();
    // What went out before the question is still on the wire, and no sign of a slow line.
    const Duration behind = std::max(filled_until_ - clock_.now(), Duration{});
    bus->start({&asked, 1}, {&result, 1});
    const TimePoint silent_until = clock_.now() + behind + time_of_look(asked, family, bit_rate(), wait);
    const bool done = bus::drive({&one, 1}, silent_until);
    if (!done && !out.heard.empty())
        bus::drive({&one, 1});
    if (!can())
        audience_.hear(asked.frame, bit_rate());
    if (const auto reply = result.reply()) {
        out.reply = *reply;
        out.round_trip = result.at - result.sent_at - behind;
        out.excess = out.round_trip - bus::predict({can(), bit_rate()}, asked).wire() - request.response_time;
    } else if (result.stage == bus::Result::Stage::done) {
        out.error = result.error;
        if (lost(out.error))
            return std::unexpected(out.error);
    } else {
        out.error = {.code = Errc::timeout,
                     .message = asked.message->name(),
                     .id = asked.id,
                     .elapsed = clock_.now() - result.sent_at};
    }
    const auto& counters = bus->conversation().counters();
    out.noise = counters.strays + counters.late > 0 || result.error.seen_size > 0;
    return out;
}

std::expected<Looks, Error> Line::look_at_all(std::span<const wire::Request> requests, const Family& family,
                                              Duration wait)
{
    const auto bus = make_bus(family, wait);
    Looks out{.results = std::vector<bus::Result>(requests.size())};
    if (auto done = bus->exchange(requests, out.results); !done)
        return std::unexpected(done.error());
    const auto& counters = bus->conversation().counters();
    out.noise = counters.strays + counters.late > 0;
    return out;
}

std::expected<std::vector<wire::Frame>, Error> Line::listen(Duration how_long)
{
    std::vector<wire::Frame> out;
    const TimePoint until = clock_.now() + how_long;
    for (;;) {
        if (auto* bytes = std::get_if<std::unique_ptr<link::ByteLink>>(&shared_->link)) {
            wire::Frame frame;
            const auto got = (*bytes)->read(frame.data);
            if (!got)
                return std::unexpected(got.error());
            frame.size = static_cast<std::uint8_t>(got->count);
            if (got->count > 0) {
                out.push_back(frame);
                continue;
            }
        } else {
            std::array<wire::Frame, 16> frames;
            const auto got = std::get<std::unique_ptr<link::CanLink>>(shared_->link)->read(frames);
            if (!got)
                return std::unexpected(got.error());
            out.insert(out.end(), frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(got->count));
            if (got->count > 0)
                continue;
        }
        if (clock_.now() >= until)
            return out;
        const link::Handle handle{std::visit([](const auto& l) { return l->handle(); }, shared_->link), false};
        clock_.wait({&handle, 1}, until);
    }
}

Duration time_of_look(const wire::Request& request, const Family& family, std::uint32_t bit_rate, Duration wait)
{
    const bus::Line wire{family.can, bit_rate != 0 ? bit_rate : family.default_bit_rate};
    return wait + (family.can ? bus::predict(wire, request).wire() : bus::frame_time(wire, request.frame.size + 1));
}

} // namespace sinew::diagnosis
