#pragma once
#include "sinew/sim/wire/station.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace sinew::sim {

/// The stations of a wire by their ids, so that a request reaches its few addressees without asking all. It remembers
/// what each station was set to when it last looked. No heap after the last `add`.
class Directory
{
public:
    using Number = std::uint32_t; ///< of a station, in the order in which they were added

    struct Entry {
        Station* station = nullptr;
        std::uint32_t bit_rate = 0;
        int id = 0;
        bool hears_all = false;
    };

    void add(Station& station)
    {
        const auto number = static_cast<Number>(entries_.size());
        entries_.push_back({.station = &station});
        by_id_.push_back(number);
        curious_.reserve(entries_.size());
        look(number);
        sort();
    }
    std::size_t size() const { return entries_.size(); }
    const Entry& operator[](Number number) const { return entries_[number]; }
    Number number_of(const Station& station) const
    {
        return static_cast<Number>(std::ranges::find(entries_, &station, &Entry::station) - entries_.begin());
    }

    /// Whether one station is set to something else than at the last look. `for_each` goes by the last look.
    bool has_changed(Number number) const
    {
        const Entry& entry = entries_[number];
        const Station& station = *entry.station;
        return entry.id != station.id() || entry.bit_rate != station.bit_rate() ||
               entry.hears_all != station.hears_all();
    }
    bool has_changed() const
    {
        for (Number number = 0; number < entries_.size(); ++number)
            if (has_changed(number))
                return true;
        return false;
    }
    /// Looks at all stations.
    void refresh()
    {
        for (Number number = 0; number < entries_.size(); ++number)
            look(number);
        sort();
    }

    /// Those who want a request for this id, -1 for all; each once.
    template <class F>
    void for_each(int addressee, F&& call) const
    {
        if (addressee < 0) {
            for (Number number = 0; number < entries_.size(); ++number)
                call(number);
            return;
        }
        const auto id_of = [&](Number number) { return entries_[number].id; };
        for (const Number number : std::ranges::equal_range(by_id_, addressee, {}, id_of))
            call(number);
        for (const Number number : curious_)
            if (entries_[number].id != addressee)
                call(number);
    }

private:
    void look(Number number)
    {
        Entry& entry = entries_[number];
        entry.id = entry.station->id();
        entry.bit_rate = entry.station->bit_rate();
        entry.hears_all = entry.station->hears_all();
    }
    void sort()
    {
        std::ranges::sort(by_id_, {}, [&](Number number) { return std::pair(entries_[number].id, number); });
        curious_.clear();
        for (Number number = 0; number < entries_.size(); ++number)
            if (entries_[number].hears_all)
                curious_.push_back(number);
    }

    std::vector<Entry> entries_;
    std::vector<Number> by_id_;   ///< sorted by id, then by number
    std::vector<Number> curious_; ///< those who hear all
};

} // namespace sinew::sim
