#include "sinew/sim/firmware/sam_program.hpp"

#include <algorithm>

namespace sinew::sim {

void SamProgram::start(const std::array<wire::Pair, 8>& instructions, int count, const sam::DeviceOptions& options)
{
    *this = {};
    instructions_ = instructions;
    wrap_ = options.motion_wrap;
    repeat_ = options.motion_repeat;
    count_ = static_cast<std::uint8_t>(std::clamp(count, 0, 8));
    is_running_ = count_ > 0;
}

// A program without a delay turns round and round: not more often than this.
void SamProgram::tick_begins()
{
    left_in_tick_ = static_cast<std::uint8_t>(instructions_.size());
}

std::optional<SamProgram::Action> SamProgram::next(const Senses& senses)
{
    while (is_running_ && left_in_tick_ > 0) {
        --left_in_tick_;
        const auto [command, data] = instructions_[line_];
        const Action action{static_cast<Instruction>(command >> 4), static_cast<std::uint8_t>(command & 0x0F), data};
        switch (action.instruction) {
        case Instruction::position:
        case Instruction::special:
        case Instruction::outputs:
            go_on();
            return action;
        case Instruction::delay:
            if (waited_ms_ < (action.sub << 8 | action.data)) {
                ++waited_ms_;
                return {};
            }
            go_on();
            break;
        case Instruction::wait_position:
        case Instruction::wait_ad:
            if (!holds(action.sub, action.instruction == Instruction::wait_ad ? senses.ad : senses.position, data))
                return {};
            go_on();
            break;
        case Instruction::repeat:
            repeat(action.data);
            break;
        case Instruction::end:
            stop();
            break;
        default: // GUESS (S64k): no instruction does nothing, one that is not defined neither
            go_on();
            break;
        }
    }
    return {};
}

// GUESS (S64c): the current value stands on the left. A condition that is not defined never holds.
bool SamProgram::holds(std::uint8_t condition, int value, int data) const
{
    switch (condition) {
    case 1:
        return value == data;
    case 2:
        return value > data;
    case 3:
        return value < data;
    case 4:
        return value >= data;
    case 5:
        return value <= data;
    default:
        return false;
    }
}

void SamProgram::go_on()
{
    waited_ms_ = 0;
    if (++line_ < count_)
        return;
    line_ = 0;
    if (wrap_ == sam::MotionWrap::stop)
        stop();
}

// GUESS (S64d): from the first instruction; after the last time it stops.
void SamProgram::repeat(int count)
{
    const int more = repeat_ == sam::MotionRepeat::total ? count - 1 : count;
    if (count != 0 && repeated_ >= more) {
        stop();
        return;
    }
    if (count != 0)
        ++repeated_;
    line_ = 0;
}

} // namespace sinew::sim
