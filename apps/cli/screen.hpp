#pragma once
#include "apps/cli/json.hpp"
#include "apps/cli/listener.hpp"

#include <set>

/// How traffic is shown: a line or an object a frame.
namespace sinew::cli {

/// Which frames are wanted; nothing named: all.
struct Filter {
    std::set<int> ids;
    std::set<std::string, std::less<>> messages;
    bool errors = false; ///< only what is wrong or was discarded

    bool passes(const Heard& heard) const;
};

/// What `--id`, `--message` and `--errors` say; the names are those of the family `only`, nullptr: of all.
std::expected<Filter, Error> filter_from(const Words& words, const Family* only);

/// "2026-01-31T23:59:59.123456Z"
std::string time_of_day(record::Time at);

/// Shows frames, and counts them.
class Screen
{
public:
    Screen(const Words& words, Filter filter)
        : filter_(std::move(filter)), json_(words.json()), absolute_(words.has("--absolute"))
    {
    }

    void show(const Heard& heard);
    /// A line that is no frame, at its place in time; `json` the same for programs, behind the times.
    void show(record::Time at, std::string_view text, Json json);
    std::uint64_t shown() const { return shown_; }
    /// How many there were, on stderr.
    void summary() const;

private:
    void see(record::Time at);
    Json begin_json(record::Time at) const;
    std::string begin_text(record::Time at) const;
    Json to_json(const Heard& heard) const;
    std::string to_text(const Heard& heard) const;

    Filter filter_;
    bool json_, absolute_;
    std::optional<record::Time> first_, last_;
    std::uint64_t frames_ = 0, errors_ = 0, shown_ = 0;
};

// ---- options of the verbs that show traffic ----

inline constexpr Option show_id_option{"--id", "N", "show this id only; may be given more than once", true};
inline constexpr Option show_message_option{"--message", "MESSAGE",
                                            "show this message only; may be given more than once", true};
inline constexpr Option errors_option{"--errors", "", "show only what is wrong or was discarded"};
inline constexpr Option absolute_option{"--absolute", "",
                                        "the time of day (UTC) and not the time since the first frame"};

} // namespace sinew::cli
