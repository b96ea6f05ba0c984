#pragma once
#include "apps/cli/verb.hpp"
#include "sinew/record/topics.hpp"

#include <functional>
#include <set>

/// What is in MCAP files, for the verbs that read them.
namespace sinew::cli {

/// A message of a joint or an event, or a frame (`Topic::frame`: `fields` is empty).
struct Recorded {
    record::Topic topic{};
    record::Time at{};
    std::string name; ///< of the joint or of the bus; empty: an event
    const record::mcap::Message* message = nullptr;
    record::JsonFields fields;
};

/// Reads a file from its beginning until `use` returns false or Ctrl-C. What is damaged is told on stderr, one line
/// each, what can be read behind it is read, and the exit code says so. An error where nothing can be read at all.
Outcome read_recording(const std::string& path, const std::function<bool(const Recorded&)>& use);

/// The value of a column as text, as it stands in the file; empty: not there.
std::string text_of(const record::JsonFields& fields, const record::Column& column);

/// `unknown_name` for a joint or bus (`kind`) that was asked for and of which nothing was there.
std::expected<void, Error> check_names(std::string_view kind, const std::string& path,
                                       std::span<const std::string> asked, const std::set<std::string>& seen);

inline constexpr Argument recording_argument{"FILE", "a recording (.mcap)"};
inline constexpr Option joint_option{"--joint", "NAME", "of this joint only; may be given more than once", true};

/// Where a file is made beside another one: run.mcap and .svg give run.svg.
std::string beside(const std::string& path, std::string_view ending);

} // namespace sinew::cli
