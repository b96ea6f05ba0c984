#include "apps/cli/stopping.hpp"

#include "sinew/family/broadcast.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace sinew::cli {
namespace {

/// Time-outs of one device must not take away the looks at another.
constexpr int fewest_looks = 4;
constexpr int most_unanswered = 2; // looks in a row, each of which the bus asks twice

bool may_be_heard_later(Errc code)
{
    return may_pass(code) || code == Errc::link_lost;
}

} // namespace

Telling Stopping::tell_to_let_go()
{
    const auto requests = driven_->driver->plan({.mode = actuator::Mode::release}, {});
    if (!requests)
        return {Rest::released, std::unexpected(requests.error())};
    acknowledges_ = requests->all().back().answered;
    return {Rest::released, carry_out(*driven_, *requests)};
}

void Stopping::tell()
{
    if (!driven_) {
        auto driven = drive(session_, device_);
        if (!driven) {
            telling_.confirmed = std::unexpected(driven.error());
            return;
        }
        driven_.emplace(std::move(*driven));
        standing_.emplace(*driven_);
        is_mute_ = !driven_->driver->plan_read(actuator::Depth::motion);
    }
    telling_ = keep_torque_ ? tell_to_hold(*driven_, telling_.place_rad) : tell_to_let_go();
}

void Stopping::look()
{
    if (!driven_) {
        ++unanswered_;
        return;
    }
    auto read = read_state(*driven_, actuator::Depth::motion);
    // Longer, and where nobody is there not worth its time-outs.
    if (read && driven_->driver->capabilities().measures_enabled)
        read = read_state(*driven_, actuator::Depth::full);
    trouble_ = read ? std::nullopt : std::optional(read.error());
    unanswered_ = read ? 0 : unanswered_ + 1;
    standing_->look(*driven_);
    stands_ = read && standing_->is_at_rest();
    before_ = read ? driven_->state : actuator::State{};
    const bool holds = stands_ && keep_torque_ && telling_.rest == Rest::holds && !before_.says_off();
    if (holds && relief_ == Relief::due && may_press(*driven_))
        relieve();
}

/// Nobody knows what it was told before: it may press on something.
void Stopping::relieve()
{
    ++reliefs_;
    if (hold_anew(*driven_, telling_))
        relief_ = Relief::done;
    else if (reliefs_ == most_reliefs)
        relief_ = Relief::given_up;
    standing_.emplace(*driven_);
    stands_ = false;
}

/// The torque, for all that is known.
bool Stopping::is_off() const
{
    return driven_->driver->capabilities().measures_enabled ? before_.says_off() : telling_.confirmed.has_value();
}

bool Stopping::is_obeyed() const
{
    return stands_ &&
           (telling_.rest == Rest::released ? is_off() : telling_.rest != Rest::holds || !before_.says_off());
}

bool Stopping::is_over() const
{
    const bool is_refused = !telling_.confirmed && !may_be_heard_later(telling_.confirmed.error().code);
    return is_refused || is_mute_ || is_obeyed() || unanswered_ >= most_unanswered;
}

bool Stopping::is_worth_another_word() const
{
    if (!telling_.confirmed || telling_.rest == Rest::braked)
        return true;
    return telling_.rest == Rest::released ? !is_off() || !acknowledges_ : !is_obeyed();
}

std::string Stopping::done() const
{
    const std::string where = place_of(*driven_);
    if (telling_.rest == Rest::holds)
        return fmt::format("holds at {}", where);
    if (telling_.rest == Rest::braked)
        return fmt::format("braked at {}", where);
    const bool is_known = acknowledges_ || driven_->driver->capabilities().measures_enabled;
    return is_known ? "released, at rest" : "released (not acknowledged), at rest";
}

Error Stopping::not_seen_at_rest() const
{
    constexpr std::string_view advice = "switch its supply off if it turns";
    const auto verb = to_verb(telling_.rest);
    if (interrupted() && telling_.confirmed)
        return {.code = Errc::stopped, .detail = fmt::format("it was told to {}, and nobody waited to see it", verb)};
    if (unanswered_ > 0 || !telling_.confirmed) {
        const Error& why = trouble_ ? *trouble_ : telling_.confirmed.error();
        const bool is_reached = may_be_heard_later(why.code);
        return Error{.code = why.code,
                     .detail = is_reached ? fmt::format("{}; {}", to_sentence(why), advice) : to_sentence(why)};
    }
    if (relief_ == Relief::given_up || (relief_ == Relief::due && reliefs_ > 0))
        return {.code = Errc::timeout, .detail = fmt::format("it {}", may_press_on)};
    if (!stands_)
        return {.code = Errc::timeout,
                .detail = fmt::format("it was told to {} and still turns; switch its supply off", verb)};
    if (telling_.rest == Rest::holds && before_.says_off())
        return {.code = Errc::timeout, .detail = "it was told to hold and says that its torque is off"};
    return {.code = Errc::timeout,
            .detail =
                fmt::format("it was told to {} and says that its torque is still on; switch its supply off", verb)};
}

std::expected<Told, Error> Stopping::outcome() const
{
    if (driven_ && telling_.confirmed && is_mute_)
        return Told{fmt::format("told to {} (not acknowledged: it is set to answer nothing)", to_verb(telling_.rest)),
                    false};
    if (!driven_ || !telling_.confirmed || !is_obeyed() || relief_ == Relief::given_up)
        return std::unexpected(not_seen_at_rest());
    return Told{done(), true};
}

void see_to_rest(Session& session, std::span<Stopping> all)
{
    TimePoint end = session.clock().now() + robot::longest_rest;
    for (int look = 1;; ++look) {
        bool left = false;
        for (auto& one : all) {
            const int reliefs = one.reliefs();
            if (!one.is_over())
                one.look();
            if (one.reliefs() != reliefs)
                end = std::max(end, session.clock().now() + robot::rest_after_relief);
            left = left || !one.is_over();
        }
        if (!left || interrupted() || (look >= fewest_looks && session.clock().now() >= end))
            return;
        for (auto& one : all)
            if (!one.is_over() && one.is_worth_another_word())
                one.tell();
        wait_until(session, session.clock().now() + between_looks);
    }
}

std::expected<Told, Error> stop_line(Session& session, const Device& everybody)
{
    const auto all = stop_of_all(*everybody.family);
    if (!all)
        return fail(Errc::unsupported,
                    fmt::format("{} has no message that stops all devices of a line", everybody.family->name));
    const auto bus = session.bus_of(everybody);
    if (!bus)
        return std::unexpected(bus.error());
    if (const auto sent = ask(**bus, all->request); !sent)
        return std::unexpected(sent.error());
    return Told{fmt::format("told to {} (not acknowledged)", to_word(all->mode)), false};
}

} // namespace sinew::cli
