#include "sinew/diagnosis/doctor.hpp"

#include "sinew/diagnosis/walk.hpp"

#include <algorithm>
#include <variant>

namespace sinew::diagnosis {
namespace {

/// A check of the port, or one that needs an open line.
using Run = std::variant<void (*)(Walk&), Checked (*)(Walk&)>;

struct Check {
    CheckInfo info;
    Run run;
    bool needs_device = false; ///< somebody must answer
};

constexpr Check walk_through[] = {
    {{"device-file", "is the port there"}, check_device_file},
    {{"permission", "may this user open it"}, check_permission},
    {{"port", "does it open, and has nobody else got it"}, check_port},
    {{"adapter", "does it keep back what it hears, and what its driver refuses"}, check_adapter},
    {{"traffic", "does somebody talk unasked"}, check_traffic},
    {{"echo", "does the adapter hear itself"}, check_echo},
    {{"bit-rate", "at which bit rate do the devices answer"}, check_bit_rate},
    {{"devices", "who answers, and who should"}, check_devices},
    {{"duplicates", "do two devices share an id"}, check_duplicates, true},
    {{"response-level", "what does a device answer, and how soon"}, check_response_level},
    {{"scales", "is each device what the robot file says"}, check_scales, true},
    {{"health", "voltage, temperature and latched faults"}, check_health, true},
    {{"round-trips", "how many answers get lost, and how long they take"}, check_round_trips, true},
    {{"counters", "what a CAN adapter refused, saw and lost meanwhile"}, check_counters},
};

/// Runs it if it is possible; false where it is not.
bool run(const Check& check, Walk& walk)
{
    if (const auto* of_port = std::get_if<void (*)(Walk&)>(&check.run)) {
        (*of_port)(walk);
        return true;
    }
    if (walk.line == nullptr || (check.needs_device && walk.present().empty()))
        return false;
    const auto done = std::get<Checked (*)(Walk&)>(check.run)(walk);
    if (!done) {
        walk.line.reset();
        walk.add("link-lost", to_sentence(done.error()));
    }
    return true;
}

} // namespace

std::vector<CheckInfo> checks()
{
    std::vector<CheckInfo> out;
    for (const auto& check : walk_through)
        out.push_back(check.info);
    return out;
}

Examination examine(const Subject& subject, const Surroundings& surroundings)
{
    Examination out;
    Walk walk(subject, surroundings, out);
    for (const auto& check : walk_through) {
        if (surroundings.stopped() || !run(check, walk))
            out.left_out.push_back(check.info.name);
        walk.finish();
    }
    if (walk.line)
        out.adapter = walk.report();
    return out;
}

} // namespace sinew::diagnosis
