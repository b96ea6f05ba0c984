#pragma once
#include "sinew/bus/predict.hpp"
#include "sinew/link/descriptor.hpp"

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::robot {

namespace guardian {
struct Memory;
/// As many have a place in the memory that a program shares with its guardian.
inline constexpr std::size_t most_buses = 16;
} // namespace guardian

/// What is known of one bus after a stop.
struct StoppedBus {
    enum class Outcome : std::uint8_t {
        sent,      ///< the frames went out, and nothing says whether they were obeyed
        confirmed, ///< every device said so itself
        failed,    ///< a link that is lost, or a device that did not confirm; `says` has which
    };
    std::string link; ///< as the program that holds it calls it
    Outcome outcome = Outcome::sent;
    std::string says;
};

/// What stops the motors of one bus, ready-made.
struct StopFrames {
    std::span<const wire::Request> seen;   ///< so long from then on; none where all have stopped
    std::span<const wire::Request> unseen; ///< later: nothing in them may name a place where a motor was
    Duration seen_for{};
};

/// A small process that outlives the program it watches, for the ways out on which a program can do nothing any more:
/// SIGKILL, a crash, an exception that nobody catches, a loop that never returns. It holds the descriptors of the links
/// and the frames that stop every bus, ready-made, and sends them, three times, when the program has ended without
/// having dismissed it.
///
/// It cannot help where the computer loses its power, where the guardian is killed together with the program, and where
/// the cable is cut: then the devices do what they do without a host (docs/guide/safety.md).
///
/// One thread at a time; only `beat`, `rest`, `stop_asked`, `stop_begun` and `stop_done` may be called from any.
/// `update` and `beat` use no heap and no system call.
class Guardian
{
public:
    struct Settings {
        /// A program that beats, and then does not for so long, is stopped as if it had ended; 0: it may take its time.
        Duration patience{};
    };

    /// Forks, so it must come before any thread and before links are opened: `unsupported` where the program already
    /// has threads, `link_failed` when the system refuses.
    static std::expected<Guardian, Error> start(Settings settings);
    static std::expected<Guardian, Error> start() { return start({}); }

    /// Dismisses it: a normal end leaves the joints as they were asked. Not so while an exception is on its way.
    ~Guardian();
    Guardian(Guardian&&) noexcept;
    Guardian& operator=(Guardian&&) noexcept;

    /// Hands over one bus, again whenever its link was opened again: a duplicate of its descriptor and what stops it.
    /// `unsupported` for links without a descriptor (those of a simulator in the same process), `out_of_range` for more
    /// than `most_buses` or 256 frames. `name` is the link as others call it.
    std::expected<void, Error> watch(std::size_t bus, std::string_view name, const link::AnyLink& link,
                                     const StopFrames& stop);
    /// Other frames for a bus that is watched: where a joint holds changes as it moves. Says also that its motors were
    /// looked at now.
    void update(std::size_t bus, const link::AnyLink& link, const StopFrames& stop) noexcept;
    /// The link of this bus is lost: its descriptor is closed there too, so that the device keeps its name.
    void forget(std::size_t bus) noexcept;

    /// The program is well. Call it every cycle.
    void beat() noexcept;
    /// It will not beat for a while, and need not; until the next beat only its end counts.
    void rest() noexcept;
    /// Somebody wants this program to stop its motors: `sinew stop`, or the guardian, which found no beat. Stays so
    /// until `stop_done`. A program that does not see to it within 0.2 s has it done by the guardian.
    bool stop_asked() const noexcept;
    /// It is about it: the frames are out. Whoever asked waits 3 s more for what comes of it.
    void stop_begun() noexcept;
    /// What became of a bus, for whoever asked; `says` is cut where it is longer than 160 bytes. Before `stop_done`.
    void stopped(std::size_t bus, StoppedBus::Outcome outcome, std::string_view says) noexcept;
    void stop_done() noexcept;

    int process_id() const { return pid_; }
    /// False when it was killed. Looks at shared memory; only when that stands still it asks the system.
    bool is_alive();

private:
    Guardian() = default;
    void dismiss() noexcept;

    guardian::Memory* memory_ = nullptr;
    link::Fd socket_;
    int pid_ = -1;
    int exceptions_ = 0;
    std::uint64_t seen_beats_ = 0;
    std::chrono::steady_clock::time_point seen_at_{};
    bool dead_ = false;
    std::filesystem::path path_;
};

/// A program of this user that a guardian watches, and the links that it holds.
struct Guarded {
    int pid = 0;
    std::vector<std::string> links;
};

std::vector<Guarded> guarded_programs();

/// Who stopped the motors of a program, and what came of it, bus by bus.
struct StoppedProgram {
    bool by_guardian = false; ///< then nothing was asked afterwards, for the program has the links
    std::vector<StoppedBus> buses;
};

/// Has such a program stop its motors, or its guardian do it. `link_not_found` when there is no such program, `timeout`
/// when nobody answered.
std::expected<StoppedProgram, Error> stop_program(int pid);

} // namespace sinew::robot
