#pragma once
#include "sinew/wire/protocol.hpp"

#include <algorithm>
#include <array>

namespace sinew::bus {

/// The answers that may still come although nobody waits for them. No family has sequence numbers: an answer that fits
/// a request may be that of an earlier one like it, and then the own answer takes its place and is to come. For framed
/// families only; bare replies are quarantined. No heap; when more answers are due than fit, all are doubtful.
class Lateness
{
public:
    /// An answer to `request` may come until then.
    [[gnu::cold, gnu::noinline]] void owe(const wire::Request& request, TimePoint until)
    {
        latest_ = std::max(latest_, until);
        Entry& entry = entry_for(request);
        if (!entry.is_of(request)) {
            if (entry.owed > 0) // no room: what is pushed out leaves all in doubt
                doubtful_until_ = std::max(doubtful_until_, entry.until);
            entry = {.asked = request};
        }
        entry.owed = static_cast<std::uint8_t>(std::min(entry.owed + 1, 255));
        entry.until = std::max(entry.until, until);
    }

    void doubt_all(TimePoint until)
    {
        doubtful_until_ = std::max(doubtful_until_, until);
        latest_ = std::max(latest_, until);
    }

    /// Whether anything is owed at `at`; if not, nothing else need be asked.
    bool is_possible(TimePoint at) const { return at <= latest_; }

    /// Whether an answer to `request` that came at `at` may be that of an earlier one. If so, the own one may come
    /// until `own_until`.
    [[gnu::cold, gnu::noinline]] bool may_be_older(const wire::Request& request, TimePoint at, TimePoint own_until)
    {
        const bool all_in_doubt = at <= doubtful_until_;
        bool older = all_in_doubt;
        for (Entry& entry : entries_)
            if (entry.owed > 0 && at <= entry.until && is_same(entry.asked, request)) {
                older = true;
                entry.until = std::max(entry.until, own_until);
                latest_ = std::max(latest_, own_until);
            }
        if (all_in_doubt)
            owe(request, own_until);
        return older;
    }

    /// A frame came that nobody waits for. If it is owed, it is owed no more; returns the request that it answers.
    const wire::Request* settle(const wire::Protocol& protocol, const wire::Frame& frame, TimePoint at)
    {
        if (!is_possible(at))
            return nullptr;
        for (Entry& entry : entries_)
            if (entry.owed > 0 && at <= entry.until &&
                protocol.answers(entry.asked.frame, *entry.asked.message, frame, entry.asked.options)) {
                --entry.owed;
                return &entry.asked;
            }
        return nullptr;
    }

private:
    struct Entry {
        wire::Request asked{};
        std::uint8_t owed = 0;
        TimePoint until{};
        bool is_of(const wire::Request& request) const
        {
            return owed > 0 && asked.message == request.message && asked.id == request.id;
        }
    };

    /// Whether the answer to one could be taken for the answer to the other: several devices answer a message for
    /// several devices, each as if it had been asked alone.
    static bool is_same(const wire::Request& a, const wire::Request& b)
    {
        const wire::Side& left = a.message->reply;
        const wire::Side& right = b.message->reply;
        const bool same_reply = a.message == b.message || (left.opcode == right.opcode && left.size == right.size);
        const bool to_several = a.message->request.layout->can_fixed || b.message->request.layout->can_fixed;
        return same_reply && (a.id == b.id || to_several);
    }

    /// Its own, a free one, or the one that is over first.
    Entry& entry_for(const wire::Request& request)
    {
        Entry* best = &entries_[0];
        for (Entry& entry : entries_) {
            if (entry.is_of(request))
                return entry;
            if (best->owed > 0 && (entry.owed == 0 || entry.until < best->until))
                best = &entry;
        }
        return *best;
    }

    std::array<Entry, 64> entries_{};
    TimePoint latest_{};         // nothing is owed after it
    TimePoint doubtful_until_{}; // every answer until then may be an older one
};

} // namespace sinew::bus
