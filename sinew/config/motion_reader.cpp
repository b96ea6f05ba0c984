#include "sinew/config/motion_reader.hpp"

#include "sinew/base/units.hpp"

namespace sinew::config {
namespace {

constexpr std::string_view kinds[] = {"pose", "move", "wait_s", "repeat", "call", "until"};
constexpr std::string_view step_keys[] = {"pose", "move",  "wait_s",     "repeat", "steps",
                                          "call", "until", "duration_s", "speed"};
constexpr std::string_view sequence_keys[] = {"steps"};
constexpr double longest_s = 1e6; ///< 11 days
constexpr std::int64_t most_times = 1'000'000'000;

/// What a condition may look at: the key without _above or _below, and the unit of the number behind it.
struct Quantity {
    Condition::Of of;
    std::string_view before, after;
    double si;
};
constexpr Quantity quantities[] = {
    {Condition::Of::position, "position", "deg", units::rad_per_deg},
    {Condition::Of::position, "position", "rad", 1.0},
    {Condition::Of::speed, "speed", "deg_s", units::rad_per_deg},
    {Condition::Of::speed, "speed", "rad_s", 1.0},
    {Condition::Of::current, "current", "a", 1.0},
};

class MotionReader
{
public:
    MotionReader(Reader& reader, RobotFile& file) : reader_(reader), file_(file) {}

    Pose pose(const toml::table& table, std::string name, Mark at)
    {
        Pose out{.name = std::move(name), .at = at};
        out.targets = targets(table, at);
        return out;
    }

    Sequence sequence(const toml::table& table, std::string name, Mark at)
    {
        owner_ = "sequence " + name;
        reader_.only(table, owner_, sequence_keys);
        Sequence out{.name = std::move(name), .at = at};
        out.steps = steps(table, at, 1);
        return out;
    }

private:
    std::size_t joint(std::string_view name, Mark at)
    {
        for (std::size_t i = 0; i < file_.joints.size(); ++i)
            if (file_.joints[i].name == name)
                return i;
        reader_.fail(at, fmt::format("there is no joint '{}'{}", name, or_nearest(name, file_.joints)));
        return 0;
    }

    void check_limits(const JointTarget& target, Mark at)
    {
        const Joint& of = file_.joints[target.joint];
        const auto beyond = [&](std::string_view what, double limit) {
            reader_.fail(at, fmt::format("{} at {:g} deg is beyond its {}: {:g} deg.", of.name,
                                         units::deg(target.position_rad), what, units::deg(limit)));
        };
        if (of.position_min_rad && target.position_rad < *of.position_min_rad)
            beyond("position_min_deg", *of.position_min_rad);
        else if (of.position_max_rad && target.position_rad > *of.position_max_rad)
            beyond("position_max_deg", *of.position_max_rad);
    }

    void target(const toml::table& table, const toml::key& key, std::vector<JointTarget>& all)
    {
        const Mark at = mark_of(key.source());
        std::string_view name = key.str();
        const bool degrees = name.ends_with("_deg");
        if (!degrees && !name.ends_with("_rad")) {
            reader_.fail(at, fmt::format("'{}' must be a joint with its unit: JOINT_deg or JOINT_rad.", name));
            return;
        }
        name.remove_suffix(4);
        const auto value = reader_.real(table, key.str());
        JointTarget out{.joint = joint(name, at), .at = at};
        if (!value || reader_.failed())
            return;
        out.position_rad = degrees ? units::rad(value->value) : value->value;
        if (std::ranges::find(all, out.joint, &JointTarget::joint) != all.end())
            reader_.fail(at, fmt::format("{} is given already; keep {}_rad or {}_deg.", name, name, name));
        check_limits(out, value->at);
        all.push_back(out);
    }

    /// Every key a joint with its unit, in the order of the file.
    std::vector<JointTarget> targets(const toml::table& table, Mark at)
    {
        if (table.empty())
            reader_.fail(at, "there is no joint in it: write JOINT_deg = ANGLE.");
        std::vector<const toml::key*> keys;
        for (const auto& [key, node] : table)
            keys.push_back(&key);
        std::ranges::sort(keys, {}, [](const toml::key* key) {
            return std::pair{key->source().begin.line, key->source().begin.column};
        });
        std::vector<JointTarget> all;
        for (const toml::key* key : keys)
            if (!reader_.failed())
                target(table, *key, all);
        return all;
    }

    std::optional<double> time(const toml::table& table, std::string_view key)
    {
        const auto value = reader_.real(table, key);
        if (value && !(value->value > 0.0 && value->value <= longest_s))
            reader_.fail(value->at, fmt::format("{} must be above 0 and no more than {:g}.", key, longest_s));
        return value ? std::optional(value->value) : std::nullopt;
    }

    void read_quantity(const toml::table& table, Mark at, Condition& out)
    {
        std::vector<std::string> keys{"joint", "within_s", "on_timeout"};
        int given = 0;
        for (const Quantity& one : quantities)
            for (const bool above : {true, false}) {
                keys.push_back(fmt::format("{}_{}_{}", one.before, above ? "above" : "below", one.after));
                const auto value = reader_.real(table, keys.back());
                if (!value)
                    continue;
                ++given;
                out.of = one.of;
                out.above = above;
                out.value = value->value * one.si;
                if (one.of != Condition::Of::position && out.value < 0.0)
                    reader_.fail(value->at, fmt::format("{} is a size and must not be below 0.", keys.back()));
            }
        reader_.only(table, "until", std::vector<std::string_view>(keys.begin(), keys.end()));
        if (given != 1)
            reader_.fail(at,
                         "until needs one thing to wait for, such as position_above_deg = 30, speed_below_deg_s = 1 "
                         "or current_above_a = 0.5.");
    }

    std::optional<Condition> until(const toml::table& step)
    {
        const toml::table* table = reader_.section(step, "until");
        if (table == nullptr)
            return {};
        const Mark at = mark_of(table->source());
        Condition out{.at = at};
        read_quantity(*table, at, out);
        const auto name = needed(reader_, reader_.text(*table, "joint"), at, "until", "joint = \"NAME\"");
        if (!reader_.failed())
            out.joint = joint(name.value, name.at);
        const auto within = time(*table, "within_s");
        if (!within)
            reader_.fail(at, "until needs within_s: how long to wait for that.");
        out.within_s = within.value_or(0.0);
        if (const auto on_timeout = reader_.text(*table, "on_timeout")) {
            out.goes_on = on_timeout->value == "continue";
            if (!out.goes_on && on_timeout->value != "stop")
                reader_.fail(on_timeout->at, "on_timeout must be \"stop\" or \"continue\".");
        }
        return out;
    }

    /// The word that says what a step does. `until` may stand beside a move.
    std::string_view kind(const toml::table& table, Mark at)
    {
        std::string_view found;
        for (const std::string_view one : kinds) {
            const bool beside = one == "until" && (found == "pose" || found == "move");
            const bool repeated = one == "call" && found == "repeat";
            if (!table.contains(one) || beside)
                continue;
            if (!found.empty() && !repeated)
                reader_.fail(at, fmt::format("a step does one thing: {} or {}, not both.", found, one));
            found = one;
        }
        if (found.empty())
            reader_.fail(at, "a step needs one of pose, move, wait_s, until, repeat or call.");
        return found;
    }

    /// Keys that say nothing about a step of this kind.
    void refuse_others(const toml::table& table, std::string_view kind, std::initializer_list<std::string_view> takes)
    {
        for (const auto& [key, node] : table)
            if (key.str() != kind && std::ranges::find(takes, key.str()) == takes.end())
                reader_.fail(mark_of(key.source()), fmt::format("{} does not go with {}.", key.str(), kind));
    }

    void read_move(const toml::table& table, std::string_view kind, Step& step)
    {
        refuse_others(table, kind, {"duration_s", "speed", "until"});
        step.kind = Step::Kind::move;
        if (kind == "pose") {
            step.name = needed(reader_, reader_.text(table, "pose"), step.at, "a step", "pose");
            if (const Pose* pose = file_.find_pose(step.name.value))
                step.targets = pose->targets;
            else
                reader_.fail(step.name.at, fmt::format("there is no pose '{}'{}", step.name.value,
                                                       or_nearest(step.name.value, file_.poses)));
        } else if (const toml::table* move = reader_.section(table, "move")) {
            step.targets = targets(*move, mark_of(move->source()));
        }
        step.duration_s = time(table, "duration_s");
        if (const auto speed = reader_.real(table, "speed")) {
            if (!(speed->value > 0.0 && speed->value <= 1.0))
                reader_.fail(speed->at, "speed must be above 0 and no more than 1: 0.5 is half of the fastest.");
            if (step.duration_s)
                reader_.fail(speed->at, "a move has a duration or a speed, not both.");
            step.speed = speed->value;
        }
        step.until = until(table);
    }

    void read_times(const toml::table& table, Step& step)
    {
        const auto* node = table.get("repeat");
        if (node != nullptr && node->is_string()) {
            const auto word = reader_.text(table, "repeat");
            if (word && word->value != "forever")
                reader_.fail(word->at, "repeat must be a number of times or \"forever\".");
            step.times.reset();
        } else if (const auto times = reader_.whole(table, "repeat")) {
            if (times->value < 1 || times->value > most_times)
                reader_.fail(times->at, fmt::format("repeat must be from 1 to {}, or \"forever\".", most_times));
            step.times = times->value;
        }
    }

    Step step(const toml::table& table, std::size_t depth)
    {
        const Mark at = mark_of(table.source());
        Step out{.at = at};
        reader_.only(table, "a step", step_keys);
        const std::string_view what = kind(table, at);
        if (reader_.failed())
            return out;
        if (what == "pose" || what == "move") {
            read_move(table, what, out);
        } else if (what == "wait_s") {
            refuse_others(table, what, {});
            out.kind = Step::Kind::wait;
            out.duration_s = time(table, "wait_s");
        } else if (what == "until") {
            refuse_others(table, what, {});
            out.kind = Step::Kind::until;
            out.until = until(table);
        } else if (what == "call") {
            refuse_others(table, what, {"repeat"});
            out.kind = Step::Kind::call;
            out.name = needed(reader_, reader_.text(table, "call"), at, "a step", "call");
            read_times(table, out);
        } else {
            refuse_others(table, what, {"steps"});
            out.kind = Step::Kind::repeat;
            read_times(table, out);
            out.steps = steps(table, at, depth + 1);
        }
        return out;
    }

    std::vector<Step> steps(const toml::table& table, Mark at, std::size_t depth)
    {
        std::vector<Step> all;
        if (depth > deepest_nesting) {
            reader_.fail(at, fmt::format("steps are nested more than {} deep.", deepest_nesting));
            return all;
        }
        for (const toml::table* one : reader_.tables(table, "steps"))
            if (!reader_.failed())
                all.push_back(step(*one, depth));
        if (all.empty())
            reader_.fail(at, fmt::format("{} needs steps, a list of at least one.", depth == 1 ? owner_ : "repeat"));
        return all;
    }

    Reader& reader_;
    RobotFile& file_;
    std::string owner_;
};

} // namespace

void read_motion(Reader& reader, const toml::table& document, RobotFile& file)
{
    MotionReader motion(reader, file);
    file.poses =
        read_named<Pose>(reader, document, "pose", [&](Reader&, const toml::table& table, std::string name, Mark at) {
            return motion.pose(table, std::move(name), at);
        });
    file.sequences = read_named<Sequence>(reader, document, "sequence",
                                          [&](Reader&, const toml::table& table, std::string name, Mark at) {
                                              return motion.sequence(table, std::move(name), at);
                                          });
    if (reader.failed())
        return;
    for (const Sequence& one : file.sequences)
        if (file.find_pose(one.name) != nullptr)
            reader.fail(one.at, fmt::format("{} is a pose already; a sequence needs another name.", one.name));
    check_calls(reader, file);
}

} // namespace sinew::config
