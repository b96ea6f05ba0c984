#include "sinew/sim/console.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/base/units.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sstream>
#include <vector>

namespace sinew::sim {
namespace {

using Said = std::expected<std::string, Error>;
using Words = std::span<const std::string>;

std::string faults_now(const World& world, std::string_view joint, std::string_view bus)
{
    std::vector<std::string_view> words;
    for (const std::string_view target : {joint, bus})
        for (const FaultKind kind : world.faults_of(target))
            words.push_back(info_of(kind).word);
    return fmt::format("{}", fmt::join(words, " "));
}

Said look(World& world, Words words)
{
    std::vector<std::string_view> joints(words.begin(), words.end());
    if (joints.empty())
        joints = world.joints();
    std::size_t longest = 5;
    for (const std::string_view joint : joints)
        longest = std::max(longest, joint.size());
    std::string out = fmt::format("{:<{}}  {:<10} {:>9} {:>9} {:>7} {:>6} {:>6}  {}\n", "joint", longest, "mode", "deg",
                                  "deg/s", "A", "V", "°C", "faults");
    for (const std::string_view joint : joints) {
        const auto now = world.look(joint);
        if (!now)
            return std::unexpected(now.error());
        const std::string& bus = world.file().find_joint(joint)->bus.value;
        std::string faults = faults_now(world, joint, bus);
        if (!now->faults.empty())
            faults += fmt::format("{}{}", faults.empty() ? "" : " ", now->faults);
        const std::string line =
            fmt::format("{:<{}}  {:<10} {:>9.2f} {:>9.2f} {:>7.2f} {:>6.1f} {:>6.1f}  {}", joint, longest, now->mode,
                        units::deg(now->position_rad), units::deg(now->velocity_rad_s), now->current_a, now->voltage_v,
                        now->temperature_c, faults);
        out += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
    }
    return out;
}

Said inject(World& world, Words words)
{
    const auto fault = parse_fault(world.file(), words);
    if (!fault)
        return std::unexpected(fault.error());
    world.inject(*fault);
    return std::string();
}

Said mend(World& world, Words words)
{
    if (words.size() != 1)
        return fail(Errc::bad_argument, "mend what? A joint or a bus");
    const std::string& target = words.front();
    if (world.file().find_joint(target) == nullptr && world.file().find_bus(target) == nullptr) {
        auto names = world.joints();
        for (const WorldBus& bus : world.buses())
            names.push_back(bus.name);
        return fail(Errc::unknown_name,
                    fmt::format("there is no joint or bus '{}'{}", target, did_you_mean(target, names)));
    }
    const std::size_t count = world.mend(target);
    return fmt::format("{} {} taken back\n", count, count == 1 ? "fault" : "faults");
}

Said kinds(World&, Words)
{
    std::string out;
    for (const FaultKindInfo& kind : fault_kinds())
        out += fmt::format("  {:<14} {}{}{}\n", kind.word, kind.says, kind.needs.empty() ? "" : "; needs ", kind.needs);
    out += "Every kind takes";
    for (const Option<Fault>& option : fault_options())
        out += fmt::format("{} {}", &option == fault_options().data() ? "" : ",", option.key);
    return out + " as KEY=VALUE where it makes sense.\n";
}

Said help(World&, Words)
{
    return std::string("look [JOINT...]                   what the devices are doing\n"
                       "fault TARGET KIND [KEY=VALUE...]  something goes wrong with a joint or a bus\n"
                       "mend TARGET                       takes that back\n"
                       "faults                            the kinds there are\n");
}

struct Command {
    std::string_view word;
    Said (*run)(World&, Words);
};

constexpr Command commands[] = {{"look", look}, {"fault", inject}, {"mend", mend}, {"faults", kinds}, {"help", help}};

} // namespace

Said respond(World& world, std::string_view line)
{
    std::istringstream stream{std::string(line)};
    std::vector<std::string> words;
    for (std::string word; stream >> word;)
        words.push_back(std::move(word));
    if (words.empty())
        return look(world, {});
    const auto found = std::ranges::find(commands, std::string_view(words.front()), &Command::word);
    if (found != std::end(commands))
        return found->run(world, Words(words).subspan(1));
    std::vector<std::string_view> names;
    for (const Command& command : commands)
        names.push_back(command.word);
    return fail(Errc::unknown_name, fmt::format("there is no command '{}'{} It is one of {}", words.front(),
                                                did_you_mean(words.front(), names), fmt::join(names, ", ")));
}

} // namespace sinew::sim
