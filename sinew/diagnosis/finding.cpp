#include "sinew/diagnosis/finding.hpp"

#include <algorithm>
#include <cassert>

namespace sinew::diagnosis {
namespace {

using enum Severity;

constexpr Kind all[] = {
    {"device-missing", "device-file", error, "There is no such port: the adapter is out, or has another name now.",
     "Plug it in, look at `ls -l /dev/serial/by-id`, and use the name there: it stays the same."},
    {"box-unreachable", "port", error, "No box from Ethernet to RS-485 takes the connection at this address.",
     "Is the box powered, on this network (`ping` its address), and is the port that of its serial line in raw mode "
     "(TCP server)? Boxes take one client as a rule: another program may have it."},
    {"interface-down", "device-file", error, "The CAN interface is there and switched off.",
     "Bring it up with `ip link set`."},
    {"no-permission", "permission", error, "This user may not open the port.",
     "Only the owner of the port and root may; ask who set it up so."},
    {"port-busy", "port", error, "Another program holds the port, and two would each get half of the answers.",
     "Close the other program."},
    {"port-shared", "port", warning, "Another program has the port open as well and may take bytes away.",
     "Close it; ModemManager and brltty are known to grab adapters that they should leave alone."},
    {"link-failed", "port", error, "The link cannot be used.", "Mend what the evidence says, and try again."},
    {"link-lost", "port", error, "The link went away while it was looked at.",
     "Look at the USB plug, the cable and the supply of the adapter; `dmesg | tail` tells more."},
    {"slow-adapter", "adapter", warning, "The adapter keeps what it hears back, so every answer comes late.",
     "Set its latency timer to 1 ms, or use an adapter that has none."},
    {"direction-not-switched", "adapter", note,
     "The driver does not switch the direction of RS-485, so the adapter has to do it by itself; nearly all that are "
     "on "
     "USB do.",
     "If nobody answers, use an adapter that switches by itself, or a port whose driver does."},
    {"adapter-silent", "adapter", warning,
     "The adapter acknowledges nothing: it is one that never does, or it does not speak SLCAN.",
     "If no motor answers either: is it the right port, and does the adapter's firmware speak SLCAN? One with "
     "candleLight firmware is a CAN interface of Linux instead: `ip link show type can`."},
    {"can-errors", "adapter", error,
     "The CAN controller has seen so many errors that it withdraws from the bus, or has done so.",
     "Look whether all have one bit rate, the bus has 120 ohm at both ends, CAN-H and CAN-L are not swapped, and "
     "somebody else is powered at all; then `sudo ip link set INTERFACE down` and up again."},
    {"foreign-traffic", "traffic", warning,
     "Somebody else talks on this line: a second master, a device that sends by itself, or noise.",
     "Switch the other master off; look at termination, ground and bit rate if there is none."},
    {"echo", "echo", error, "The adapter hears itself, and its own bytes would be taken for answers.",
     "Add echo=on to the link."},
    {"wrong-baud", "bit-rate", error, "The device works at another bit rate than the one that is used.",
     "Use the rate at which it answers, or set the device to that of the bus."},
    {"wrong-family", "bit-rate", error, "The devices on this link speak another protocol than the robot file says.",
     "Correct `family` in the robot file, or look whether the links of two buses are mixed up."},
    {"no-answer", "devices", error, "No device answers.",
     "Is the supply on? Are the two data wires swapped, is ground connected? `sinew scan LINK --all` tries every id at "
     "every bit rate."},
    {"missing-device", "devices", error, "A device of the robot file does not answer, at no bit rate.",
     "Look at its supply, its plug and its id; `sinew scan LINK` shows the ids that answer. Two that share an id and "
     "stand at the same place look like one: turn one of them, or unplug it."},
    {"broken-chain", "devices", error, "From one place in the chain on nobody answers.",
     "Look at the cable and the plugs there, and at the supply of what comes after."},
    {"unexpected-device", "devices", note, "A device answers that the robot file does not know.",
     "Add it to the robot file, or take it off the line."},
    {"duplicate-id", "duplicates", error, "Two devices have the same id and talk into each other's answers.",
     "Unplug one of them, give the other another id with `sinew id`, and plug it in again."},
    {"silent-response-level", "response-level", error,
     "A SAM at response level 2 carries out commands and never answers: from the wire it looks like one that is not "
     "there.",
     "Set response level 0 with `sinew send LINK --family sam --id ID set-drive-mode response_level=0 reverse=0`; that "
     "writes its flash."},
    {"response-level-differs", "response-level", warning,
     "The robot file and the device disagree on what is answered, so sinew waits for answers that do not come or gets "
     "some that it does not wait for.",
     "Correct `response_level` under profile_options of the joint."},
    {"response-time-differs", "response-level", warning,
     "The device answers later than the robot file says, so its answers may be missed.",
     "Correct `response_time_us` under profile_options of the joint."},
    {"wrong-model", "scales", error,
     "The device is another model than the robot file says, and every scale depends on the model.",
     "Correct `model` of the joint."},
    {"wrong-profile", "scales", error,
     "The device speaks another firmware line than the robot file says: scales differ, and commands may.",
     "Correct `profile` of the joint."},
    {"wrong-scale", "scales", error, "A scale of the robot file is not that of the device.",
     "Correct it under profile_options of the joint."},
    {"unconfirmed-scale", "scales", note,
     "Nobody has said how the motor reads its speed limit, so sinew sends the reading that can only be too slow.",
     "Name the profile of the joint, or `max_speed_lsb_dps`."},
    {"low-voltage", "health", error, "The supply is too low: motors are weak, stop, or reset.",
     "Measure at the connector while it moves; look at the supply, its current limit and thin cables."},
    {"high-voltage", "health", error, "The supply is above what the device is made for.",
     "Switch it off and set the supply right."},
    {"over-temperature", "health", error, "The device is too hot and has stopped, or is about to.",
     "Take its load away and let it cool down; look for what jams it."},
    {"latched-over-temperature", "health", error,
     "The device was too hot, has cooled down, and stays off until its error is cleared.",
     "Find out what made it hot, then `sinew send LINK --family rmd --id ID clear-error`."},
    {"device-fault", "health", error, "The device has stopped or holds back because of a fault of its own.",
     "Find the cause, then `sinew send LINK --family rmd --id ID clear-error`."},
    {"unexplained-fault", "health", warning, "The device reports a fault that no document explains.",
     "Look it up in the papers of the motor; the bits are in the evidence."},
    {"unreadable", "health", error, "The device is there, but not everything can be read from it.",
     "Look at the findings before this one; the line may be bad, or the profile wrong."},
    {"lossy-line", "round-trips", warning, "Answers get lost or arrive wrong.",
     "Look at plugs, ground, termination at both ends and cable length, and keep motor cables away from it."},
    {"bus-errors", "counters", warning,
     "While the devices were asked, the adapter refused frames or the controller "
     "saw errors on the bus.",
     "Look whether all have one bit rate, the bus has 120 ohm at both ends, CAN-H and CAN-L are not swapped, and "
     "somebody else is powered at all."},
    {"frames-lost", "counters", warning,
     "Frames were lost in the adapter or in the kernel, for nobody fetched them in "
     "time.",
     "Free the processor for sinew (`[bus.NAME.realtime]` of a robot file asks for it), or use a faster adapter; an "
     "SLCAN "
     "adapter on a real serial line wants a higher baud=."},
};

} // namespace

std::string_view to_word(Severity severity)
{
    switch (severity) {
    case ok:
        return "ok";
    case note:
        return "note";
    case warning:
        return "warning";
    case error:
        return "error";
    }
    return "error";
}

std::span<const Kind> kinds()
{
    return all;
}

const Kind& kind(std::string_view name)
{
    const auto* found = std::ranges::find(all, name, &Kind::name);
    assert(found != std::end(all));
    return *found;
}

Severity worst(std::span<const Finding> findings)
{
    Severity out = ok;
    for (const auto& finding : findings)
        out = std::max(out, finding.severity);
    return out;
}

} // namespace sinew::diagnosis
