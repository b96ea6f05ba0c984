#include "sinew/base/bytes.hpp"
#include "sinew/sim/world.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::sim {

std::string World::flash() const
{
    std::string out = fmt::format("# What the devices of {} keep without power.\nversion = 1\n", file_.name);
    for (const Inhabitant& inhabitant : inhabitants_) {
        out += fmt::format("\n[joint.{}]\nfamily = \"{}\"\n", inhabitant.joint, buses_[inhabitant.bus].family->name);
        for (const KeptValue& kept : inhabitant.device->kept())
            out += fmt::format("{} = {}\n", kept.key, kept.value);
    }
    return out;
}

std::uint64_t World::flash_writes() const
{
    std::uint64_t all = 0;
    for (const Inhabitant& inhabitant : inhabitants_)
        all += inhabitant.device->flash_writes();
    return all;
}

std::expected<void, Error> World::restore(const config::FlashFile& flash)
{
    for (const config::FlashJoint& joint : flash.joints) {
        const auto found = std::ranges::find(inhabitants_, joint.name, &Inhabitant::joint);
        if (found == inhabitants_.end()) {
            const std::string near = did_you_mean(joint.name, joints());
            return config::fail_at(flash, joint.at,
                                   fmt::format("the robot has no joint '{}'{}", joint.name, near.empty() ? "." : near));
        }
        const std::string_view family = buses_[found->bus].family->name;
        if (joint.family.value != family)
            return config::fail_at(flash, joint.family.at,
                                   fmt::format("{} is a {} in {}.", joint.name, family, file_.path));
        if (auto done = found->device->restore(flash, joint); !done)
            return done;
    }
    // Ids and bit rates may be others.
    for (WorldBus& bus : buses_)
        std::visit([](auto& wire) { wire.refresh(); }, bus.wire);
    return {};
}

} // namespace sinew::sim
