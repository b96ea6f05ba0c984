#include "sinew/diagnosis/scanner.hpp"

#include "sinew/diagnosis/probes.hpp"
#include "sinew/family/sam/messages.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

namespace sinew::diagnosis {
namespace {

using namespace std::chrono_literals;

/// Adapters and hosts add no more than this, nearly all of them: the latency timer of FTDI is 16 ms.
constexpr Duration usual_excess = 20ms;
constexpr Duration least_excess = 6ms;
/// Once answers came, the line has shown how fast it is: twice the slowest of them is enough, and what comes later
/// still is noticed.
constexpr Duration known_excess = 2ms;
constexpr int answers_to_know_a_line = 4;
/// Where something was heard and not understood it is looked at again with time to spare.
constexpr Duration patience = 200ms;
/// What is heard may be the answer to a question that went out so long ago. The last id of a pass gets that time as
/// well: nobody after it would notice.
constexpr Duration latest_answer = 60ms;
/// A line that never falls silent must not make every probe a patient one.
constexpr int most_second_looks = 256;
/// Devices are numbered from the bottom as a rule.
constexpr int likely_ids = 8;

constexpr bool is_same_place(const Pass& a, const Pass& b)
{
    return a.family == b.family && a.bit_rate == b.bit_rate && a.ids == b.ids;
}

bool has_rate(const Family& family, std::uint32_t rate)
{
    return std::ranges::any_of(family.bit_rates, [&](const BitRate& r) { return r.bps == rate; });
}

std::optional<wire::Range> common(wire::Range a, wire::Range b)
{
    const wire::Range out{std::max(a.low, b.low), std::min(a.high, b.high)};
    return out.low <= out.high ? std::optional(out) : std::nullopt;
}

/// Collects passes: those at low ids before the rest of the same places.
struct Order {
    std::optional<wire::Range> ids;
    std::vector<Pass> out{};
    std::vector<Pass> later{};

    void add(const Family& family, std::uint32_t rate)
    {
        const auto wanted = ids ? common(family.ids, *ids) : family.ids;
        if (!wanted)
            return;
        const wire::Range low{wanted->low, wanted->low + likely_ids - 1};
        add_unique(out, {&family, rate, family.can ? *wanted : *common(*wanted, low), true});
        if (!family.can && wanted->high > low.high)
            add_unique(later, {&family, rate, {low.high + 1, wanted->high}, false});
    }

    void end_of_likely_places()
    {
        out.insert(out.end(), later.begin(), later.end());
        later.clear();
    }

    void add_unique(std::vector<Pass>& to, const Pass& pass)
    {
        const auto known = [&](const Pass& p) { return is_same_place(p, pass); };
        if (std::ranges::none_of(out, known) && std::ranges::none_of(later, known))
            to.push_back(pass);
    }
};

/// The ways in which a family's firmware lines answer on CAN: lines that answer with another identifier are asked once
/// more, for their answers belong to no default request.
std::vector<const wire::Profile*> ways_to_answer(const Family& family)
{
    std::vector<const wire::Profile*> out;
    for (const auto* line : family.profiles)
        if (std::ranges::none_of(out, [&](const wire::Profile* known) {
                return known->options.can_reply_base == line->options.can_reply_base;
            }))
            out.push_back(line);
    return out;
}

Duration unhurried(const Family& family)
{
    return std::max(family.response_time.typical + usual_excess, family.response_time.most + least_excess);
}

Duration patient(const Family& family)
{
    return family.response_time.most + patience;
}

Duration for_the_last(const Family& family)
{
    return family.response_time.most + latest_answer;
}

} // namespace

std::vector<Pass> passes(const ScanPlan& plan, bool can, std::uint32_t link_bit_rate)
{
    std::vector<const Family*> wanted;
    for (const auto* family : families())
        if (family->can == can &&
            (plan.families.empty() || std::ranges::find(plan.families, family) != plan.families.end()))
            wanted.push_back(family);
    Order order{.ids = plan.ids};
    for (const auto* family : wanted) {
        if (plan.bit_rate)
            order.add(*family, *plan.bit_rate);
        else if (can || link_bit_rate == 0 || has_rate(*family, link_bit_rate))
            order.add(*family, link_bit_rate);
    }
    if (!can && !plan.bit_rate && link_bit_rate != 0) {
        for (const auto* family : wanted)
            order.add(*family, family->default_bit_rate);
        order.end_of_likely_places();
        std::multimap<std::uint32_t, const Family*, std::greater<>> rest; // equal rates keep the order of the families
        for (const auto* family : wanted)
            for (const auto& rate : family->bit_rates)
                rest.emplace(rate.bps, family);
        for (const auto& [rate, family] : rest)
            order.add(*family, rate);
    }
    order.end_of_likely_places();
    return order.out;
}

std::span<const Pass> likely_places(std::span<const Pass> passes)
{
    const auto other = std::ranges::find_if_not(passes, [&](const Pass& pass) {
        return pass.likely &&
               (pass.bit_rate == passes.front().bit_rate || pass.bit_rate == pass.family->default_bit_rate);
    });
    return passes.first(static_cast<std::size_t>(other - passes.begin()));
}

Duration expected_time(const Pass& pass)
{
    const auto& family = *pass.family;
    const auto count = pass.ids.high - pass.ids.low + 1;
    const auto one = ways_to_ask(family, static_cast<int>(pass.ids.low)).front();
    if (!family.can)
        return (count - 1) * time_of_look(one, family, pass.bit_rate, unhurried(family)) +
               time_of_look(one, family, pass.bit_rate, for_the_last(family));
    // All questions go out back to back and share the wire with their answers.
    constexpr int rounds = 2;
    return rounds * static_cast<int>(ways_to_answer(family).size()) *
           (count * time_of_look(one, family, pass.bit_rate, {}) + patient(family));
}

Duration expected_time(std::span<const Pass> passes)
{
    Duration sum{};
    for (const auto& pass : passes)
        sum += expected_time(pass);
    return sum;
}

std::expected<void, Error> Scanner::sweep(std::span<const Pass> passes, bool all, const Stopped& stopped, const At& at,
                                          std::vector<Found>& found)
{
    hurries_ = !all;
    std::vector<Pass> due(passes.begin(), passes.end());
    while (!due.empty() && !stopped()) {
        const Pass pass = due.front();
        due.erase(due.begin());
        const std::size_t known = found.size();
        const auto done = run(pass, stopped, at, found);
        std::ranges::sort(found, {}, [](const Found& f) { return std::tuple(f.family->name, f.bit_rate, f.id); });
        if (!done)
            return done;
        const auto also_there = [&](const Pass& other) {
            return other.bit_rate == pass.bit_rate && (other.family == pass.family || other.likely);
        };
        if (found.size() > known && !all)
            std::erase_if(due, [&](const Pass& other) { return !also_there(other); });
    }
    return {};
}

std::expected<void, Error> Scanner::run(const Pass& pass, const Stopped& stopped, const At& at,
                                        std::vector<Found>& found)
{
    if (const auto set = line_.set_bit_rate(pass.bit_rate); !set)
        return std::unexpected(set.error());
    else if (!*set)
        return {};
    if (!pass.family->can)
        return run_serial(pass, stopped, at, found);
    at(pass, static_cast<int>(pass.ids.low));
    return run_can(pass, found);
}

std::expected<void, Error> Scanner::run_can(const Pass& pass, std::vector<Found>& found)
{
    std::vector<int> ids(static_cast<std::size_t>(pass.ids.high - pass.ids.low + 1));
    std::iota(ids.begin(), ids.end(), static_cast<int>(pass.ids.low));
    for (const auto* line : ways_to_answer(*pass.family)) {
        auto silent = ask_all(pass, *line, ids, patient(*pass.family), found);
        if (silent && silent->noise && !silent->ids.empty())
            // Shorter: the time that is left of the predicted one is the other master's.
            silent = ask_all(pass, *line, silent->ids, unhurried(*pass.family), found);
        if (!silent)
            return std::unexpected(silent.error());
    }
    return {};
}

std::expected<Scanner::Silent, Error> Scanner::ask_all(const Pass& pass, const wire::Profile& line,
                                                       std::span<const int> ids, Duration wait,
                                                       std::vector<Found>& found)
{
    const auto base = line.options.can_reply_base;
    std::vector<wire::Request> requests;
    for (const int id : ids) {
        requests.push_back(ways_to_ask(*pass.family, id).front());
        requests.back().options.can_reply_base = base;
    }
    const auto looks = line_.look_at_all(requests, *pass.family, wait);
    if (!looks)
        return std::unexpected(looks.error());
    Silent out{.noise = looks->noise};
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const auto& result = looks->results[i];
        if (!result.good) {
            out.ids.push_back(ids[i]);
            continue;
        }
        found.push_back({.family = pass.family,
                         .bit_rate = line_.bit_rate(),
                         .id = ids[i],
                         .model = {},
                         .line = base != 0 ? line.name : std::string_view{},
                         .round_trip = result.at - result.sent_at});
    }
    return out;
}

/// How long an answer may take to begin, from what the line has shown.
Duration Scanner::wait_for(const Family& family) const
{
    if (!hurries_ || measured_ < answers_to_know_a_line)
        return unhurried(family);
    return family.response_time.typical + std::clamp(2 * slowest_, known_excess, usual_excess);
}

std::expected<void, Error> Scanner::ask(const Family& family, int id, Duration wait, bool& noise,
                                        std::vector<Found>& found)
{
    auto request = line_.safe_one(ways_to_ask(family, id));
    if (!request) {
        ++left_out_;
        return {};
    }
    auto seen = line_.look(*request, family, wait);
    if (!seen)
        return std::unexpected(seen.error());
    noise = noise || seen->noise;
    // A bare answer to anything but a ping names nobody: it may be that of the id before, come late. It does not come
    // late twice.
    const bool names_itself = !family.protocol->bare_replies() || request->message->name() == "ping";
    if (seen->reply && !names_itself) {
        seen = line_.look(*request, family, patient(family));
        if (!seen)
            return std::unexpected(seen.error());
    }
    if (!seen->reply)
        return {};
    ++measured_;
    slowest_ = std::max(slowest_, seen->excess);
    found.push_back({.family = &family,
                     .bit_rate = line_.bit_rate(),
                     .id = id,
                     .model = model_of(family, id),
                     .round_trip = seen->round_trip});
    return get_to_know(family, id);
}

/// Asks one that answered until the line is known.
std::expected<void, Error> Scanner::get_to_know(const Family& family, int id)
{
    for (int i = measured_; i < answers_to_know_a_line; ++i) {
        const auto request = line_.safe_one(ways_to_ask(family, id));
        if (!request)
            return {};
        const auto seen = line_.look(*request, family, patient(family));
        if (!seen)
            return std::unexpected(seen.error());
        if (!seen->reply)
            return {};
        ++measured_;
        slowest_ = std::max(slowest_, seen->excess);
    }
    return {};
}

/// What a SAM says of itself; the other families do not tell.
std::string Scanner::model_of(const Family& family, int id)
{
    const auto request = line_.safe_one(ways_to_ask_model(family, id));
    if (!request)
        return {};
    const auto seen = line_.look(*request, family, patient(family));
    if (!seen || !seen->reply)
        return {};
    const auto said = wire::decode_reply<sam::ReadFirmwareVersion>(*seen->reply);
    const auto* model = said ? sam::find_model(said->message.model_number) : nullptr;
    return model != nullptr ? std::string(model->name) : std::string{};
}

std::expected<void, Error> Scanner::run_serial(const Pass& pass, const Stopped& stopped, const At& at,
                                               std::vector<Found>& found)
{
    std::vector<Asked> asked;
    const auto last = static_cast<int>(pass.ids.high);
    for (int id = static_cast<int>(pass.ids.low); id <= last && !stopped(); ++id) {
        at(pass, id);
        bool noise = false;
        const TimePoint now = line_.clock().now();
        std::erase_if(asked, [&](const Asked& one) { return one.at < now - latest_answer; });
        asked.push_back({id, now});
        const Duration wait = id < last ? wait_for(*pass.family) : for_the_last(*pass.family);
        if (auto done = ask(*pass.family, id, wait, noise, found); !done)
            return done;
        if (noise)
            if (auto done = look_again(pass, asked, stopped, found); !done)
                return done;
    }
    return {};
}

/// At all ids that may have been the reason for what was heard.
std::expected<void, Error> Scanner::look_again(const Pass& pass, std::span<const Asked> asked, const Stopped& stopped,
                                               std::vector<Found>& found)
{
    const auto is_found = [&](int id) {
        return std::ranges::any_of(found, [&](const Found& f) {
            return f.family == pass.family && f.id == id && f.bit_rate == line_.bit_rate();
        });
    };
    for (const auto& one : asked) {
        if (stopped() || is_found(one.id) || ++second_looks_ > most_second_looks)
            continue;
        bool noise = false;
        if (auto done = ask(*pass.family, one.id, patient(*pass.family), noise, found); !done)
            return done;
    }
    return {};
}

} // namespace sinew::diagnosis
