#pragma once
#include "sinew/family/sam/models.hpp"
#include "sinew/wire/message.hpp"

#include <array>
#include <cstdint>
#include <optional>

namespace sinew::sim {

/// The self-running motion of a SAM (L492-507): up to eight instructions of a command byte — instruction in the high
/// nibble, sub instruction in the low one — and a data byte. One run of `next` a tick, until it has no more.
class SamProgram
{
public:
    enum class Instruction : std::uint8_t {
        none,
        position,
        special,
        delay,
        outputs,
        wait_position,
        wait_ad,
        repeat,
        end
    };

    /// What its conditions look at.
    struct Senses {
        int position = 0; ///< quick coordinates
        int ad = 0;       ///< of the external port, 8 bit
    };
    /// What the device has to do: an instruction that is `position`, `special` or `outputs`.
    struct Action {
        Instruction instruction{};
        std::uint8_t sub = 0;
        std::uint8_t data = 0;
    };

    /// From its first instruction. No instruction: it does not run (L492).
    void start(const std::array<wire::Pair, 8>& instructions, int count, const sam::DeviceOptions& options);
    void stop() { is_running_ = false; }
    bool is_running() const { return is_running_; }

    void tick_begins();
    /// The next action of this tick. Nothing: it waits, has come to its end or has done enough for a tick.
    std::optional<Action> next(const Senses& senses);

private:
    bool holds(std::uint8_t condition, int value, int data) const;
    void go_on();
    void repeat(int count);

    std::array<wire::Pair, 8> instructions_{};
    sam::MotionWrap wrap_{};
    sam::MotionRepeat repeat_{};
    std::uint8_t count_ = 0;
    std::uint8_t line_ = 0;
    std::uint8_t left_in_tick_ = 0;
    std::uint8_t repeated_ = 0;
    std::uint16_t waited_ms_ = 0;
    bool is_running_ = false;
};

} // namespace sinew::sim
