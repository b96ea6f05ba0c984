#pragma once
#include "sinew/family/rmd/lines.hpp"
#include "tests/bus/matching.hpp"

#include <bitset>

/// The same on CAN, where answers come in any order.
namespace sinew::tests {

inline rmd::MotorState rmd_state(std::uint32_t number)
{
    rmd::MotorState state{.temperature = 30};
    state.speed = static_cast<std::int16_t>(number & 0x7FFF);
    state.encoder = static_cast<std::uint16_t>(number >> 15);
    return state;
}

/// The number stands in the last four bytes, whichever message it is.
inline std::uint32_t rmd_number(const wire::MessageInfo& message, const wire::Frame& frame)
{
    if (&message == &wire::info_of<rmd::ReadMultiTurnAngle>) {
        const auto reply = wire::decode_reply<rmd::ReadMultiTurnAngle>(frame);
        return reply ? static_cast<std::uint32_t>(reply->message.angle) : 0;
    }
    return static_cast<std::uint32_t>(frame.data[4] | frame.data[5] << 8) |
           static_cast<std::uint32_t>(frame.data[6] | frame.data[7] << 8) << 15;
}

struct RmdFaults {
    sim::WireFaults frames{}; ///< `delay_reply` by up to `reply_delay`
    double hang_up = 0.0;     ///< in an exchange, or just after it, the link is lost with what it holds, and comes back
    double other_master = 0.0; ///< before an exchange another master asks one of the devices the same, not long before
    double unasked = 0.0;      ///< or something else, of which nobody here knows
};

/// Eight motors.
class RmdMotors
{
public:
    explicit RmdMotors(CanRig& rig)
    {
        for (int id = 1; id <= 8; ++id)
            rig.add(id, [this, id](const wire::Frame& request, TimePoint at) { return answer(id, request, at); });
    }

    std::vector<Given> given = std::vector<Given>(1); ///< from number 1 on

private:
    std::optional<sim::Answer> answer(int id, const wire::Frame& request, TimePoint at)
    {
        static constexpr wire::Profile line{.name = "rmd", .messages = rmd::manual_messages};
        const auto* message = rmd::protocol().identify(request, wire::Direction::request, line);
        const auto number = static_cast<std::uint32_t>(given.size());
        std::optional<wire::Frame> frame;
        if (message == &wire::info_of<rmd::ReadMultiTurnAngle>)
            frame = *wire::encode_reply<rmd::ReadMultiTurnAngle>(id, {.angle = number});
        else if (message == &wire::info_of<rmd::ReadStatus2>)
            frame = *wire::encode_reply<rmd::ReadStatus2>(id, rmd_state(number));
        else if (message == &wire::info_of<rmd::ReadStatus3>)
            frame = *wire::encode_reply<rmd::ReadStatus3>(id, {});
        else if (message == &wire::info_of<rmd::TorqueClosedLoop> ||
                 (message == &wire::info_of<rmd::MultiMotorTorque> && id <= 4))
            frame = *wire::encode_reply<rmd::TorqueClosedLoop>(id, rmd_state(number));
        if (!frame)
            return std::nullopt;
        given.push_back({id, message, false, at, *frame});
        return sim::Answer{*frame, 100us};
    }
};

inline std::vector<wire::Request> rmd_choice()
{
    std::vector<wire::Request> all;
    for (int id = 1; id <= 8; ++id) {
        all.push_back(*wire::make_request(id, rmd::ReadMultiTurnAngle{}, {}, 100us));
        all.push_back(*wire::make_request(id, rmd::ReadStatus2{}, {}, 100us));
        all.push_back(*wire::make_request(id, rmd::TorqueClosedLoop{}, {}, 100us));
    }
    all.push_back(*wire::make_request(0, rmd::MultiMotorTorque{}, {}, 100us));
    return all;
}

/// What is for several motors is answered by those with the ids 1 to 4, each of them once.
inline void judge_rmd(std::span<const Given> all, const wire::Request& asked, const bus::Result& result, Tally& tally)
{
    std::bitset<256> answered;
    for (const auto& frame : std::span(result.replies).first(result.reply_count)) {
        const std::uint32_t number = rmd_number(*asked.message, frame);
        if (number == 0 || number >= all.size() || all[number].frame != frame) {
            ++tally.foreign; // no device ever sent this
            continue;
        }
        const Given& given = all[number];
        const auto id = static_cast<std::size_t>(given.id);
        const bool to_several = asked.message->request.layout->can_fixed;
        const bool is_his = to_several ? id >= 1 && id <= 4 && !answered.test(id) : given.id == asked.id;
        answered.set(id);
        if (!is_his || given.message->reply.opcode != asked.message->reply.opcode)
            ++tally.foreign;
        else if (given.heard_at < result.sent_at)
            tally.note_older(result, given.heard_at);
        else
            ++tally.right;
    }
}

/// What happens to the line before an exchange, and in it.
inline void disturb(CanRig& rig, const RmdFaults& faults, std::span<const wire::Request> choice, WireClock& clock,
                    Alarm& alarm, sim::Dice& dice)
{
    rig.wire.faults().reply_delay = faults.frames.reply_delay * static_cast<int>(1 + dice.pick(1000)) / 1000;
    if (dice.falls(5e-4)) { // at most one is unplugged, half of the time none
        const unsigned out = dice.pick(16);
        for (std::size_t i = 0; i < rig.stations.size(); ++i)
            rig.stations[i]->is_plugged = i != out;
        rig.wire.refresh();
    }
    if (dice.falls(faults.other_master)) {
        rig.wire.host_sends(choice[dice.pick(24)].frame, 1'000'000, clock.now());
        clock.wait({}, clock.now() + Duration(dice.pick(500'000)));
    }
    if (dice.falls(faults.unasked))
        rig.wire.host_sends(wire::make_request(1 + static_cast<int>(dice.pick(8)), rmd::ReadStatus3{})->frame,
                            1'000'000, clock.now());
    if (dice.falls(faults.hang_up))
        alarm.set(clock.now() + Duration(dice.pick(3'000'000)), [&rig] { rig.unplug_host(); });
}

inline Tally run_rmd(std::uint64_t count, const RmdFaults& faults)
{
    WireClock clock;
    Alarm alarm(clock);
    CanRig rig(clock, 1'000'000, settings);
    const RmdMotors motors(rig);
    const auto choice = rmd_choice();
    rig.bus->set_reopen([&rig] { return rig.plug_in(); }, Duration(1));
    rig.wire.faults() = faults.frames;
    rig.wire.seed(test::seed());
    sim::Dice dice;
    dice.seed(test::seed());
    Tally tally;
    Ask ask;
    while (tally.asked < count) {
        ask.requests.clear();
        for (unsigned i = 1 + dice.pick(8); i > 0; --i)
            ask.requests.push_back(choice[dice.pick(static_cast<unsigned>(choice.size()))]);
        ask.results.resize(ask.requests.size());
        disturb(rig, faults, choice, clock, alarm, dice);
        const TimePoint began = clock.now();
        (void)rig.bus->exchange(ask.requests, ask.results);
        check_waits(*rig.bus, ask, began, tally);
        alarm.make_up_for_it();
        for (std::size_t i = 0; i < ask.results.size(); ++i) {
            ++tally.asked;
            tally.none += !ask.results[i].good;
            if (ask.results[i].good)
                judge_rmd(motors.given, ask.requests[i], ask.results[i], tally);
        }
        if (dice.falls(0.3))
            clock.wait({}, clock.now() + Duration(dice.pick(100'000)) * 20);
    }
    tally.losses = rig.bus->losses();
    return tally;
}

} // namespace sinew::tests
