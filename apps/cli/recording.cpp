#include "apps/cli/recording.hpp"

#include "apps/cli/device.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/interrupt.hpp"
#include "sinew/base/bytes.hpp"

#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <utility>

namespace sinew::cli {
namespace {

using record::Topic;

/// What a message is; nothing where it is none of ours.
std::expected<std::optional<Recorded>, Error> recorded_from(const record::mcap::Reader& reader,
                                                            const record::mcap::Message& message)
{
    Recorded out{.topic = record::topic_of(reader, *message.channel), .message = &message};
    if (out.topic == Topic::other)
        return std::nullopt;
    if (message.stamp.log_time_ns > static_cast<std::uint64_t>(Duration::max().count()))
        return fail(Errc::bad_file, "a message with a time beyond the year 2262");
    out.at = record::Time{Duration{static_cast<std::int64_t>(message.stamp.log_time_ns)}};
    if (const auto* name = message.channel->find(out.topic == Topic::frame ? "bus" : "joint"))
        out.name = *name;
    if (out.topic == Topic::frame)
        return out;
    auto fields = record::JsonFields::parse(record::text_of(message.data));
    if (!fields)
        return std::unexpected(fields.error());
    out.fields = std::move(*fields);
    return out;
}

} // namespace

Outcome read_recording(const std::string& path, const std::function<bool(const Recorded&)>& use)
{
    std::error_code none;
    std::ifstream file(path, std::ios::binary);
    if (!file || std::filesystem::is_directory(path, none))
        return fail(Errc::bad_file, fmt::format("'{}' cannot be read", path));
    record::mcap::Reader reader;
    int code = exit_done;
    std::string told; // one damage may spoil several records
    const auto tell = [&](const Error& error) {
        if (std::exchange(told, error.detail) != error.detail)
            fmt::print(stderr, "sinew: {}, {}\n", path, error.detail);
        code = exit_code(error.code);
    };
    std::array<char, 256 * 1024> piece;
    for (;;) {
        auto item = reader.next();
        if (!item && !reader.is_mcap())
            return fail(Errc::bad_file,
                        fmt::format("{} is no MCAP file; sinew import makes one of a candump log or pcapng", path));
        if (!item) {
            tell(item.error());
        } else if (!*item) {
            if (!file)
                return code;
            file.read(piece.data(), piece.size());
            reader.feed(record::bytes_of({piece.data(), static_cast<std::size_t>(file.gcount())}));
            if (!file)
                reader.end();
        } else if (const auto* message = std::get_if<record::mcap::Message>(&**item)) {
            const auto recorded = recorded_from(reader, *message);
            if (!recorded)
                tell(recorded.error());
            else if (*recorded && (!use(**recorded) || interrupted()))
                return code;
        }
    }
}

std::expected<void, Error> check_names(std::string_view kind, const std::string& path,
                                       std::span<const std::string> asked, const std::set<std::string>& seen)
{
    const std::vector<std::string_view> names(seen.begin(), seen.end());
    for (const auto& name : asked)
        if (!seen.contains(name))
            return fail(Errc::unknown_name,
                        fmt::format("{} has nothing of a {} '{}'{}", path, kind, name, suggestion(name, names)));
    return {};
}

std::string text_of(const record::JsonFields& fields, const record::Column& column)
{
    if (const auto* text = fields.text(column.name))
        return *text;
    if (const auto number = fields.number(column.name))
        return fmt::format("{}", *number);
    if (const auto flag = fields.flag(column.name))
        return *flag ? "true" : "false";
    return {};
}

std::string beside(const std::string& path, std::string_view ending)
{
    auto out = std::filesystem::path(path == "-" ? "stdin" : path);
    return out.replace_extension(ending).string();
}

} // namespace sinew::cli
