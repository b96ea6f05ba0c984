#include "sinew/bus/bus.hpp"

#include <algorithm>
#include <utility>

/// How a bus gets its link back.
namespace sinew::bus {

void Bus::set_reopen(link::Reopen reopen, Duration period)
{
    reopen_ = std::move(reopen);
    reopen_period_ = period;
    next_try_ = clock_.now();
}

void Bus::try_to_reopen()
{
    if (!reopen_ || clock_.now() < next_try_)
        return;
    std::expected<void, Error> back;
    if (auto opened = reopen_())
        back = adopt(std::move(*opened));
    else
        back = std::unexpected(std::move(opened.error()));
    if (!back)
        lost_error_.detail = name_ + " is lost and not back yet: " + to_sentence(back.error());
    trouble_.lost = !back;
    next_try_ = clock_.now() + reopen_period_;
}

std::expected<void, Error> Bus::adopt(link::AnyLink opened)
{
    if (opened.index() != link_.index())
        return fail(Errc::bad_argument, "it was opened again as a link of another kind");
    const auto rate = [](const link::AnyLink& l) { return std::visit([](const auto& x) { return x->state(); }, l); };
    if (asked_bit_rate_ != 0 && rate(opened).bit_rate != asked_bit_rate_) {
        const auto set = std::visit([&](auto& l) { return l->set_bit_rate(asked_bit_rate_); }, opened);
        if (!set)
            return std::unexpected(set.error());
    }
    link_ = std::move(opened);
    choose_kind();
    conversation_.set_bit_rate(link_state().bit_rate);
    conversation_.distrust(clock_.now());
    return {};
}

TimePoint Bus::tend()
{
    // The results of the latest exchange were its caller's and may be gone.
    conversation_.begin({}, {});
    if (trouble_.lost)
        try_to_reopen();
    else
        read_link();
    return trouble_.lost && reopen_ ? next_try_ : TimePoint::max();
}

bool Bus::wait_for_link(TimePoint until)
{
    for (;;) {
        const TimePoint again = std::min(tend(), until);
        if (!trouble_.lost)
            return true;
        if (stop_.load() || clock_.now() >= until)
            return false;
        clock_.wait(handles(), again);
    }
}

} // namespace sinew::bus
