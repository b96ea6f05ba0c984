#pragma once
#include "sinew/link/link.hpp"
#include "sinew/robot/guardian.hpp"

#include <array>
#include <atomic>
#include <cstdint>

/// The memory that a program shares with its guardian. For the files of the guardian only.
namespace sinew::robot::guardian {

inline constexpr std::size_t most_pieces = 256; ///< frames of one list that stop one bus
inline constexpr std::size_t longest_name = 256;
inline constexpr std::size_t longest_word = 160; ///< of what became of a bus

/// One frame as the descriptor takes it, and how long the line needs before the next one.
struct Piece {
    std::uint32_t pause_us = 0;
    std::uint8_t size = 0;
    std::array<std::uint8_t, link::longest_spelling> bytes{};
};

struct Pieces {
    std::uint32_t count = 0;
    std::array<Piece, most_pieces> all{};
};

/// What stops one bus.
struct Stop {
    std::int64_t seen_until_ns = 0; ///< of the steady clock, which both processes share
    Pieces seen, unseen;
};

/// What stops a bus stands here twice: one is whole while the other is written, so a program may die at any moment.
struct Bus {
    std::array<char, longest_name> link{};
    std::atomic<std::uint32_t> written{0}; ///< so often; by turns into one and the other
    std::array<Stop, 2> stops{};
    /// Where it was written that time.
    Stop& stop(std::uint32_t time) { return time % 2 == 0 ? stops.front() : stops.back(); }
    const Stop& stop(std::uint32_t time) const { return time % 2 == 0 ? stops.front() : stops.back(); }
    // What became of the last stop: written by the program before `stop_done`, or by the guardian where that did it.
    std::atomic<std::uint8_t> outcome{0};
    std::array<char, longest_word> says{};
};

struct Memory {
    std::atomic<std::uint64_t> beats{0};       ///< of the program
    std::atomic<std::uint64_t> watch_beats{0}; ///< of the guardian
    std::atomic<bool> stop_asked{false};       ///< from outside, or because the beats had ended
    std::atomic<bool> stop_begun{false};       ///< by the program: the frames are out
    std::atomic<bool> stop_done{false};        ///< by the program, and it is known what became of it
    std::array<Bus, most_buses> buses{};
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "two processes share them");

/// What a program tells its guardian; a descriptor comes along with `watch`.
enum class Word : std::uint8_t { watch, forget, dismiss };

struct Letter {
    Word word = Word::dismiss;
    std::uint8_t bus = 0;
};

/// Serves until the program has ended; never returns. `socket` is the guardian's end of its socket; `listener`, which
/// may be -1, is where others ask. Both are its own from now on.
[[noreturn]] void watch_over(Memory& memory, int program, int socket, int listener, Duration patience);

} // namespace sinew::robot::guardian
