#include "sinew/sim/world.hpp"

#include "sinew/base/seconds.hpp"

#include <algorithm>
#include <limits>

namespace sinew::sim {

void World::inject(const Fault& fault)
{
    const TimePoint begins = now_ + from_seconds(fault.at_s);
    faults_.push_back({.fault = fault,
                       .begins = begins,
                       .ends = fault.for_s > 0.0 ? begins + from_seconds(fault.for_s) : TimePoint::max()});
}

std::size_t World::mend(std::string_view target)
{
    for (Scheduled& scheduled : faults_)
        if (scheduled.hits(target) && scheduled.is_on)
            turn(scheduled, false);
    return std::erase_if(faults_, [&](const Scheduled& scheduled) { return scheduled.hits(target); });
}

std::vector<FaultKind> World::faults_of(std::string_view target) const
{
    std::vector<FaultKind> kinds;
    for (const Scheduled& scheduled : faults_)
        if (scheduled.is_on && scheduled.hits(target))
            kinds.push_back(scheduled.fault.kind);
    return kinds;
}

void World::run_faults()
{
    bool some_over = false;
    for (Scheduled& scheduled : faults_) {
        if (!scheduled.is_on && now_ >= scheduled.begins && now_ < scheduled.ends)
            turn(scheduled, true);
        else if (scheduled.is_on && now_ >= scheduled.ends)
            turn(scheduled, false);
        some_over |= now_ >= scheduled.ends;
    }
    if (some_over)
        std::erase_if(faults_, [&](const Scheduled& scheduled) { return now_ >= scheduled.ends; });
}

void World::turn(Scheduled& scheduled, bool on)
{
    scheduled.is_on = on;
    const Fault& fault = scheduled.fault;
    switch (fault.kind) {
    case FaultKind::flip_bits:
    case FaultKind::drop_bytes:
    case FaultKind::add_bytes:
    case FaultKind::delay_replies:
        turn_wire(fault);
        return;
    case FaultKind::power_cut:
    case FaultKind::brown_out:
        if (!fault.bus.empty()) {
            turn_supplies(fault, on);
            return;
        }
        break;
    default:
        break;
    }
    if (Device* device = find_device(fault.joint))
        turn_device(fault, *device, on);
}

void World::turn_device(const Fault& fault, Device& device, bool on)
{
    switch (fault.kind) {
    case FaultKind::duplicate_id:
        device.force_id(on ? static_cast<int>(fault.id) : -1);
        break;
    case FaultKind::unplug:
        on ? device.unplug() : device.plug();
        break;
    case FaultKind::power_cut:
        device.limit_supply(on ? 0.0 : std::numeric_limits<double>::infinity());
        break;
    case FaultKind::brown_out:
        device.limit_supply(on ? fault.voltage_v : std::numeric_limits<double>::infinity());
        break;
    case FaultKind::stuck_gear:
        device.plant().jam(on);
        break;
    case FaultKind::hot_motor:
        if (on)
            device.plant().heat_to(fault.temperature_c);
        break;
    case FaultKind::wrong_baud:
        device.force_bit_rate(on ? static_cast<std::uint32_t>(fault.bit_rate) : 0);
        break;
    case FaultKind::push:
        device.plant().push(on ? fault.torque_nm : 0.0);
        break;
    default:
        break;
    }
}

void World::turn_supplies(const Fault& fault, bool on)
{
    for (WorldBus& bus : buses_)
        if (bus.name == fault.bus)
            for (Supply& supply : bus.supplies)
                on ? supply.set(fault.kind == FaultKind::power_cut ? 0.0 : fault.voltage_v) : supply.restore();
}

// Several faults of one target add up to one set of chances.
void World::turn_wire(const Fault& changed)
{
    WireFaults all;
    for (const Scheduled& scheduled : faults_) {
        const Fault& fault = scheduled.fault;
        if (!scheduled.is_on || fault.joint != changed.joint || fault.bus != changed.bus)
            continue;
        if (fault.kind == FaultKind::flip_bits)
            all.flip_bit = fault.probability;
        else if (fault.kind == FaultKind::drop_bytes)
            all.drop_byte = fault.probability;
        else if (fault.kind == FaultKind::add_bytes)
            all.add_byte = fault.probability;
        else if (fault.kind == FaultKind::delay_replies) {
            all.delay_reply = fault.probability;
            all.reply_delay = from_seconds(fault.delay_s);
        }
    }
    const Device* device = find_device(changed.joint);
    for (WorldBus& bus : buses_)
        std::visit(
            [&](auto& wire) {
                if (bus.name == changed.bus)
                    wire.faults() = all;
                else if (device != nullptr && bus.name == file_.find_joint(changed.joint)->bus.value)
                    wire.set_faults(*device, all);
            },
            bus.wire);
}

} // namespace sinew::sim
