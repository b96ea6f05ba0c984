#include "apps/cli/scanner.hpp"

#include "apps/cli/interrupt.hpp"

#include <algorithm>
#include <functional>
#include <map>

namespace sinew::cli {
namespace {

/// A device that answers at all does it within this, in nearly every adapter.
constexpr Duration quick_margin = std::chrono::milliseconds(20);
/// Once answers came, the line has shown how fast it is: twice the slowest of them is enough, and what comes
/// later still is noticed.
constexpr Duration least_margin = std::chrono::milliseconds(6);
constexpr int answers_to_know_a_line = 2;
/// Where something was heard and not understood it is looked at again with time to spare.
constexpr Duration patient_margin = std::chrono::milliseconds(200);
/// So many ids before the one at which something was heard may have been meant.
constexpr int looked_at_again = 8;
/// A line that never falls silent must not make every probe a patient one.
constexpr int most_second_looks = 64;

constexpr bus::Settings with_margin(Duration margin)
{
    return {.margin_at_first = margin, .margin_least = margin, .late_max = {}, .read_retries = 0};
}
constexpr bus::Settings patient = with_margin(patient_margin);

void add_unique(std::vector<Pass>& out, const Pass& pass)
{
    const bool known =
        std::ranges::any_of(out, [&](const Pass& p) { return p.family == pass.family && p.bit_rate == pass.bit_rate; });
    if (!known)
        out.push_back(pass);
}

bool has_rate(const Family& family, std::uint32_t rate)
{
    return std::ranges::any_of(family.bit_rates, [&](const BitRate& r) { return r.bps == rate; });
}

} // namespace

std::vector<Pass> passes(const ScanPlan& plan, bool can, std::uint32_t link_bit_rate)
{
    std::vector<const Family*> wanted;
    for (const auto* family : families())
        if (family->can == can &&
            (plan.families.empty() || std::ranges::find(plan.families, family) != plan.families.end()))
            wanted.push_back(family);
    std::vector<Pass> out;
    const auto add = [&](const Family& family, std::uint32_t rate) {
        wire::Range ids = family.ids;
        if (plan.ids)
            ids = {std::max(ids.low, plan.ids->low), std::min(ids.high, plan.ids->high)};
        if (ids.low <= ids.high)
            add_unique(out, {&family, rate, ids});
    };
    for (const auto* family : wanted) {
        if (plan.bit_rate)
            add(*family, *plan.bit_rate);
        else if (can || link_bit_rate == 0 || has_rate(*family, link_bit_rate))
            add(*family, link_bit_rate);
    }
    if (can || plan.bit_rate || link_bit_rate == 0)
        return out;
    for (const auto* family : wanted)
        add(*family, family->default_bit_rate);
    std::multimap<std::uint32_t, const Family*, std::greater<>> rest; // equal rates keep the order of the families
    for (const auto* family : wanted)
        for (const auto& rate : family->bit_rates)
            rest.emplace(rate.bps, family);
    for (const auto& [rate, family] : rest)
        add(*family, rate);
    return out;
}

Duration expected_time(const Pass& pass)
{
    const auto count = pass.ids.high - pass.ids.low + 1;
    constexpr std::int64_t can_frame_bits = 135;
    const auto one = ways_to_ask(*pass.family, static_cast<int>(pass.ids.low)).front();
    const std::int64_t rate = pass.bit_rate != 0 ? pass.bit_rate : pass.family->default_bit_rate;
    if (pass.family->can)
        return count * bit_time(2 * can_frame_bits, rate) + quick_margin;
    const auto bits = 10 * static_cast<std::int64_t>(one.frame.size + one.message->reply.size);
    return count * (bit_time(bits, rate) + one.response_time + quick_margin);
}

/// The one link of a scan, lent to the buses that look at it in turn.
struct Scanner::Shared {
    link::AnyLink link;
};

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

link::LinkState state_of(const link::AnyLink& link)
{
    return std::visit([](const auto& l) { return l->state(); }, link);
}

bool lost(const Error& error)
{
    return error.code == Errc::link_lost || error.code == Errc::link_failed;
}

} // namespace

Scanner::Scanner(link::AnyLink link, link::Clock& clock) : link_(new Shared{std::move(link)}), clock_(clock) {}
Scanner::~Scanner() = default;

std::uint32_t Scanner::link_bit_rate() const
{
    return state_of(link_->link).bit_rate;
}
bool Scanner::can() const
{
    return std::holds_alternative<std::unique_ptr<link::CanLink>>(link_->link);
}

std::unique_ptr<bus::Bus> Scanner::make_bus(const Family& family, const bus::Settings& settings)
{
    return std::make_unique<bus::Bus>("scan", lend(link_->link), clock_, *family.protocol, settings);
}

std::expected<void, Error> Scanner::run(const Pass& pass, const std::function<bool()>& stopped,
                                        const std::function<void(int id)>& at, std::vector<Found>& found)
{
    if (pass.bit_rate != 0 && pass.bit_rate != link_bit_rate()) {
        const auto set = std::visit([&](auto& l) { return l->set_bit_rate(pass.bit_rate); }, link_->link);
        if (!set)
            return lost(set.error()) ? std::expected<void, Error>(std::unexpected(set.error()))
                                     : std::expected<void, Error>{};
    }
    return pass.family->can ? run_can(pass, found) : run_serial(pass, stopped, at, found);
}

std::expected<void, Error> Scanner::run_can(const Pass& pass, std::vector<Found>& found)
{
    const auto bus = make_bus(*pass.family, patient);
    StopOnInterrupt stop(*bus);
    // Lines that answer with another identifier are asked once more: their answers belong to no default request.
    std::vector<std::uint32_t> reply_bases;
    for (const auto* line : pass.family->profiles) {
        const auto base = line->options.can_reply_base;
        if (std::ranges::find(reply_bases, base) != reply_bases.end())
            continue;
        reply_bases.push_back(base);
        std::vector<wire::Request> requests;
        for (auto id = pass.ids.low; id <= pass.ids.high; ++id) {
            requests.push_back(ways_to_ask(*pass.family, static_cast<int>(id)).front());
            requests.back().options.can_reply_base = base;
        }
        std::vector<bus::Result> results(requests.size());
        if (auto done = bus->exchange(requests, results); !done)
            return done;
        for (std::size_t i = 0; i < results.size(); ++i)
            if (results[i].good)
                found.push_back({.family = pass.family,
                                 .bit_rate = link_bit_rate(),
                                 .id = requests[i].id,
                                 .model = {},
                                 .line = base != 0 ? line->name : std::string_view{},
                                 .round_trip = results[i].at - results[i].sent_at});
    }
    return {};
}

/// One request and what came of it.
struct Scanner::Look {
    std::optional<wire::Frame> reply;
    Duration round_trip{};
    bool noise = false; ///< something was heard that is no answer to it
};

std::expected<Scanner::Look, Error> Scanner::look(const wire::Request& request, const Family& family,
                                                  const bus::Settings& settings)
{
    // A bus of its own, because one that remembers a time-out would send a probe that nobody has looked at.
    const auto bus = make_bus(family, settings);
    StopOnInterrupt stop(*bus);
    bus::Result result;
    if (auto done = bus->exchange({&request, 1}, {&result, 1}); !done)
        return std::unexpected(done.error());
    audience_.hear(request.frame, link_bit_rate());
    const auto& counters = bus->conversation().counters();
    Look out{.round_trip = result.at - result.sent_at,
             .noise = counters.strays + counters.late > 0 || result.error.seen_size > 0};
    if (const auto reply = result.reply())
        out.reply = *reply;
    return out;
}

std::expected<bool, Error> Scanner::ask(const Family& family, int id, const bus::Settings& settings, bool& noise,
                                        std::vector<Found>& found)
{
    const auto request = safe_one(ways_to_ask(family, id), audience_, link_bit_rate());
    if (!request) {
        ++left_out_;
        return false;
    }
    auto seen = look(*request, family, settings);
    if (!seen)
        return std::unexpected(seen.error());
    noise = noise || seen->noise;
    // A bare answer to anything but a ping names nobody: it may be that of the id before, come late. It does not come
    // late twice.
    const bool names_itself = !family.protocol->bare_replies() || request->message->name() == "ping";
    if (seen->reply && !names_itself) {
        seen = look(*request, family, patient);
        if (!seen)
            return std::unexpected(seen.error());
    }
    if (!seen->reply)
        return false;
    found.push_back({.family = &family,
                     .bit_rate = link_bit_rate(),
                     .id = id,
                     .model = model_of(family, id),
                     .round_trip = seen->round_trip});
    return true;
}

/// What a SAM says of itself; the other families do not tell.
std::string Scanner::model_of(const Family& family, int id)
{
    const auto request = safe_one(ways_to_ask_model(family, id), audience_, link_bit_rate());
    if (!request)
        return {};
    const auto seen = look(*request, family, patient);
    if (!seen || !seen->reply)
        return {};
    const auto said = wire::decode_reply<sam::ReadFirmwareVersion>(*seen->reply);
    const auto* model = said ? sam::find_model(said->message.model_number) : nullptr;
    return model != nullptr ? std::string(model->name) : std::string{};
}

std::expected<void, Error> Scanner::run_serial(const Pass& pass, const std::function<bool()>& stopped,
                                               const std::function<void(int id)>& at, std::vector<Found>& found)
{
    int second_looks = 0;
    const auto is_found = [&](int id) {
        return std::ranges::any_of(found, [&](const Found& f) {
            return f.family == pass.family && f.id == id && f.bit_rate == link_bit_rate();
        });
    };
    const auto first = static_cast<int>(pass.ids.low);
    Duration slowest{};
    for (int id = first; id <= pass.ids.high && !stopped(); ++id) {
        at(id);
        bool noise = false;
        const std::size_t known = found.size();
        // An answer that comes late is heard by the next id, except that to the last one.
        const bool fast = known >= answers_to_know_a_line && id < pass.ids.high;
        const Duration margin = fast ? std::clamp(2 * slowest, least_margin, quick_margin) : quick_margin;
        if (const auto asked = ask(*pass.family, id, with_margin(margin), noise, found); !asked)
            return std::unexpected(asked.error());
        if (found.size() > known)
            slowest = std::max(slowest, found.back().round_trip);
        if (!noise)
            continue;
        for (int again = std::max(first, id - looked_at_again + 1); again <= id && !stopped(); ++again) {
            if (is_found(again) || ++second_looks > most_second_looks)
                continue;
            if (const auto asked = ask(*pass.family, again, patient, noise, found); !asked)
                return std::unexpected(asked.error());
        }
    }
    std::ranges::sort(found, {}, [](const Found& f) { return std::tuple(f.family->name, f.bit_rate, f.id); });
    return {};
}

} // namespace sinew::cli
