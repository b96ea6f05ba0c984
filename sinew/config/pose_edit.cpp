#include "sinew/config/pose_edit.hpp"

#include "sinew/base/units.hpp"
#include "sinew/config/reader.hpp"

#include <cmath>

namespace sinew::config {
namespace {

/// The lines of a text with their ends.
std::vector<std::string> lines_of(std::string_view text)
{
    std::vector<std::string> all;
    while (!text.empty()) {
        const auto end = text.find('\n');
        const auto size = end == std::string_view::npos ? text.size() : end + 1;
        all.emplace_back(text.substr(0, size));
        text.remove_prefix(size);
    }
    return all;
}

/// A number without digits that mean nothing: what a thousandth of a degree is.
std::string number(double value, int decimals)
{
    std::string out = fmt::format("{:.{}f}", value, decimals);
    out.erase(out.find_last_not_of('0') + 1);
    if (out.ends_with('.'))
        out.pop_back();
    return out == "-0" ? "0" : out;
}

std::string angle(double rad, bool degrees)
{
    constexpr int decimals_deg = 3, decimals_rad = 5;
    return degrees ? number(units::deg(rad), decimals_deg) : number(rad, decimals_rad);
}

/// `key = 12.5   # note` with another number.
void replace_value(std::string& line, const std::string& value)
{
    const auto begin = line.find_first_not_of(" \t", line.find('=') + 1);
    auto end = line.find_first_of("#\r\n", begin);
    end = end == std::string::npos ? line.size() : end;
    while (end > begin && (line[end - 1] == ' ' || line[end - 1] == '\t'))
        --end;
    line.replace(begin, end - begin, value);
}

struct Place {
    const toml::key* key = nullptr;
    bool degrees = true;
};

/// The key of a joint in the table of a pose.
std::optional<Place> place_of(const toml::table& table, const std::string& joint)
{
    for (const bool degrees : {true, false}) {
        const auto at = table.find(joint + (degrees ? "_deg" : "_rad"));
        if (at != table.end())
            return Place{&at->first, degrees};
    }
    return {};
}

bool is_header(const std::string& line)
{
    const auto first = line.find_first_not_of(" \t");
    return first != std::string::npos && line[first] == '[';
}

class Editor
{
public:
    explicit Editor(std::string_view text)
        : lines_(lines_of(text)), end_(text.find("\r\n") == std::string_view::npos ? "\n" : "\r\n")
    {
    }

    /// False when the pose does not stand as a table of its own.
    bool change(const toml::table& table, std::span<const NewTarget> targets)
    {
        const std::size_t header = table.source().begin.line - 1;
        if (table.is_inline() || header >= lines_.size() || !is_header(lines_[header]))
            return false;
        std::size_t last = header;
        for (const auto& [key, node] : table)
            last = std::max<std::size_t>(last, key.source().begin.line - 1);
        std::string added;
        for (const NewTarget& target : targets) {
            if (const auto place = place_of(table, target.joint))
                replace_value(lines_[place->key->source().begin.line - 1], angle(target.position_rad, place->degrees));
            else
                added += line_of(target);
        }
        if (!added.empty())
            complete(lines_[last]) += added;
        return true;
    }

    void append(std::string_view pose, std::span<const NewTarget> targets)
    {
        std::string added = fmt::format("{}[pose.{}]{}", end_, pose, end_);
        for (const NewTarget& target : targets)
            added += line_of(target);
        if (lines_.empty())
            lines_.emplace_back();
        complete(lines_.back()) += added;
    }

    std::string text() const
    {
        std::string out;
        for (const std::string& line : lines_)
            out += line;
        return out;
    }

private:
    std::string line_of(const NewTarget& target) const
    {
        return fmt::format("{}_deg = {}{}", target.joint, angle(target.position_rad, true), end_);
    }

    std::string& complete(std::string& line)
    {
        if (!line.ends_with('\n'))
            line += end_;
        return line;
    }

    std::vector<std::string> lines_;
    std::string_view end_;
};

/// Whether nothing but the pose is different.
bool is_as_meant(const RobotFile& before, const RobotFile& after, std::string_view pose,
                 std::span<const NewTarget> targets)
{
    constexpr double rounding_rad = 1e-4;
    const Pose* changed = after.find_pose(pose);
    const std::size_t poses = before.poses.size() + (before.find_pose(pose) == nullptr ? 1 : 0);
    if (changed == nullptr || after.poses.size() != poses || after.joints.size() != before.joints.size() ||
        after.sequences.size() != before.sequences.size())
        return false;
    return std::ranges::all_of(targets, [&](const NewTarget& target) {
        return std::ranges::any_of(changed->targets, [&](const JointTarget& one) {
            return after.joints[one.joint].name == target.joint &&
                   std::abs(one.position_rad - target.position_rad) < rounding_rad;
        });
    });
}

} // namespace

std::expected<std::string, Error> with_pose(std::string_view text, const std::string& path, std::string_view pose,
                                            std::span<const NewTarget> targets)
{
    const auto before = parse_robot_file(text, path);
    if (!before)
        return std::unexpected(before.error());
    if (!is_name(pose))
        return fail(Errc::bad_argument,
                    fmt::format("the name of a pose may only have letters, digits, - and _, not '{}'", pose));
    if (before->find_sequence(pose) != nullptr)
        return fail(Errc::bad_argument, fmt::format("{} is a sequence of {}; a pose needs another name", pose, path));
    Editor editor(text);
    const auto document = parse_document(text, path);
    if (before->find_pose(pose) == nullptr) {
        editor.append(pose, targets);
    } else if (!editor.change(*document->at_path(fmt::format("pose.{}", pose)).as_table(), targets)) {
        return fail(Errc::bad_argument, fmt::format("write the pose {} of {} as a table of its own, [pose.{}], so that "
                                                    "its lines can be changed",
                                                    pose, path, pose));
    }
    std::string out = editor.text();
    const auto after = parse_robot_file(out, path);
    if (!after)
        return std::unexpected(after.error());
    if (!is_as_meant(*before, *after, pose, targets))
        return fail(Errc::bad_argument, fmt::format("the pose {} of {} is written in a way that cannot be changed "
                                                    "line by line; write each joint on a line of its own",
                                                    pose, path));
    return out;
}

} // namespace sinew::config
