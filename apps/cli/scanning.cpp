#include "apps/cli/scanning.hpp"

#include "apps/cli/session.hpp"
#include "apps/cli/terminal.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using diagnosis::expected_time;
using diagnosis::Found;
using diagnosis::Pass;
using diagnosis::ScanPlan;

std::string time_text(Duration time)
{
    const double s = seconds(time);
    return s < 90.0 ? fmt::format("{} s", static_cast<int>(std::ceil(s)))
                    : fmt::format("{:.0f} min", std::ceil(s / 60.0));
}

std::string rate_text(std::uint32_t rate)
{
    return rate != 0 ? fmt::format("{} baud", rate) : "the rate of the link";
}

/// Places are rates here, whatever the family.
std::size_t rates_of(std::span<const Pass> passes)
{
    std::vector<std::uint32_t> rates;
    for (const auto& pass : passes)
        if (std::ranges::find(rates, pass.bit_rate) == rates.end())
            rates.push_back(pass.bit_rate);
    return rates.size();
}

void announce(std::span<const Pass> passes, bool all)
{
    const auto likely = diagnosis::likely_places(passes);
    const auto rates = rates_of(passes);
    if (likely.size() == passes.size() || rates == 1 || all)
        fmt::print(stderr, "Looking at {}: up to {}.\n",
                   rates == 1 ? rate_text(passes.front().bit_rate) : fmt::format("{} bit rates", rates),
                   time_text(expected_time(passes)));
    else
        fmt::print(stderr,
                   "Looking at the likely places first: up to {}; if nobody answers, at {} bit rates, up to {} in "
                   "all.\n",
                   time_text(expected_time(likely)), rates, time_text(expected_time(passes)));
    std::fflush(stderr);
}

std::expected<void, Error> look(diagnosis::Scanner& scanner, const std::vector<Pass>& all, bool go_on,
                                link::Clock& clock, std::vector<Found>& found)
{
    const TimePoint begin = clock.now();
    const Duration expected = expected_time(all);
    const auto at = [&](const Pass& pass, int id) {
        progress(fmt::format("{} {}, id {} of {}, {} found, {} of {}", pass.family->name, rate_text(pass.bit_rate), id,
                             pass.ids.high, found.size(), time_text(clock.now() - begin), time_text(expected)));
    };
    auto done = scanner.sweep(all, go_on, interrupted, at, found);
    end_progress();
    return done;
}

} // namespace

std::string link_to_open(const std::string& word, const ScanPlan& plan)
{
    const auto* family = plan.families.empty() ? find_family("sam") : plan.families.front();
    return with_bit_rate(word, *family, plan.bit_rate.value_or(0));
}

std::expected<std::size_t, Error> look_for_devices(const std::string& link, const ScanPlan& plan,
                                                   std::vector<Found>& found)
{
    Session session;
    auto opened = session.open(link);
    if (!opened)
        return std::unexpected(opened.error());
    diagnosis::Line line(std::move(*opened), session.clock());
    diagnosis::Scanner scanner(line);
    const auto all = passes(plan, line.can(), line.bit_rate());
    if (all.empty() && !plan.families.empty() && plan.families.front()->can != line.can())
        return fail(Errc::bad_argument,
                    fmt::format("{} devices are on {}, which {} is not", plan.families.front()->name,
                                plan.families.front()->can ? "CAN" : "serial lines", link));
    if (all.empty())
        return fail(Errc::bad_argument, "no family has such an id");
    announce(all, plan.all);
    if (auto done = look(scanner, all, plan.all, session.clock(), found); !done)
        return std::unexpected(done.error());
    return scanner.left_out();
}

std::unexpected<Error> nobody_answered(const std::string& link)
{
    if (record::is_replay(link))
        return fail(Errc::timeout, fmt::format("{} has no answer to what scan asks; sinew replay shows what is in it",
                                               link::parse_uri(link)->target));
    return fail(Errc::timeout,
                fmt::format("nobody answered on {}; is the device powered, and is the wiring right?", link));
}

} // namespace sinew::cli
