#pragma once
#include "sinew/record/mcap_writer.hpp"
#include "sinew/record/ring.hpp"
#include "sinew/record/topics.hpp"
#include "sinew/record/whole_file.hpp"

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>

namespace sinew::record {

/// Records a robot while it runs: frames, states, commands and events into an MCAP file (`topics.hpp` says how).
///
///     auto recorder = record::Recorder::create("run.mcap", {.zero = record::time_of_day_zero(clock)});
///     const auto legs = (*recorder)->add_bus({.name = "legs", .family = "rmd", .can = true});
///     const auto knee = (*recorder)->add_joint({.name = "knee", .bus = "legs", .id = 1});
///     (*recorder)->run_in_thread();
///     bus.set_tap([&](const bus::Tapped& tapped) { (*recorder)->frame(legs, tapped); });
///     while (...)
///         (*recorder)->state(knee, state);
///     auto ended = (*recorder)->finish();
///
/// Everything is declared before the first push. A push copies into a ring that was taken beforehand: no heap, no lock,
/// no system call, and where the ring is full the entry is lost and counted, for a robot must not wait for a disk. All
/// pushes come from one thread. What they become is formatted and written by `drain` or `flush`, from the thread that
/// calls them or from the recorder's own.
///
/// The file is whole at any moment: killed, it lacks its end and at most the last second; `Recovery` completes it. When
/// it can grow no more (a full disk) recording ends with an error, and the file is ended as well as it can be.
class Recorder
{
public:
    struct Settings {
        std::size_t ring_bytes = 16U << 20U; ///< a second of 16 joints at 1 kHz with all their frames takes a half
        Time zero{}; ///< time of day at which the clock of the buses stood at zero; the default: virtual time
    };
    enum class Bus : std::uint16_t {};
    enum class Joint : std::uint16_t {};
    enum class Level : std::uint8_t { info, warning, error };

    /// A file that is there is written over. `bad_argument` where it cannot be written.
    static std::expected<std::unique_ptr<Recorder>, Error> create(const std::filesystem::path& path, Settings settings);
    /// Finishes; what then goes wrong is not told.
    ~Recorder();
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    // ---- before the first push ----

    Bus add_bus(const BusInfo& bus);
    Joint add_joint(const JointInfo& joint);
    /// A file to be kept with the recording, such as the robot file.
    std::expected<void, Error> attach(std::string name, std::string media_type, std::string data);
    /// From now on a thread of the recorder's own writes, twenty times a second.
    void run_in_thread();

    // ---- in the loop; false: the ring was full ----

    bool frame(Bus bus, const bus::Tapped& tapped) noexcept;
    /// Values whose time is not newer than what was told last are left out. In joint units where the caller's are.
    bool state(Joint joint, const actuator::State& state) noexcept;
    bool command(Joint joint, TimePoint at, const actuator::Command& command) noexcept;
    /// `name`: one word such as "link-lost".
    bool event(TimePoint at, Level level, std::string_view name, std::string_view text) noexcept;

    std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }
    /// Nothing is written any more; `finish` says why. From any thread.
    bool failed() const { return failed_.load(std::memory_order_relaxed); }
    /// Of the ring, 0 … 1: for whoever calls `drain` before it is full.
    double fill() const { return static_cast<double>(ring_.in_use()) / static_cast<double>(ring_.size()); }

    // ---- outside of the loop, where no thread of its own does it ----

    /// Formats what was pushed and writes what fills a chunk, or is a second old. The first error stays.
    std::expected<void, Error> drain();
    /// All that was pushed is in the file.
    std::expected<void, Error> flush();
    /// The same, and the end of the file; nothing can be pushed afterwards. Also ends the thread, and tells its error.
    std::expected<void, Error> finish();
    /// Messages that are in the file or on their way.
    std::uint64_t messages() const { return writer_.messages(); }

private:
    struct Entry;
    struct Known {
        std::uint16_t channel = 0;
        std::uint32_t sequence = 0;
        bool can = false; // of a bus
        Told told;        // of states
    };

    Recorder(WholeFile file, Settings settings);
    std::uint16_t schema(Topic topic);
    bool push(const Entry& entry, std::span<const std::byte> first, std::span<const std::byte> second) noexcept;
    void take(std::span<const std::byte> bytes);
    void tell_dropped();
    std::expected<void, Error> write();
    std::uint64_t time_ns(std::int64_t at_ns) const;

    Ring ring_;
    std::atomic<std::uint64_t> dropped_{0};

    WholeFile file_;
    mcap::Writer writer_;
    Time zero_;
    std::array<std::uint16_t, 4> schemas_{}; // by topic; 0: not yet
    std::vector<Known> buses_, states_, commands_;
    Known events_;
    std::string scratch_;
    std::uint64_t told_dropped_ = 0;
    std::uint64_t chunk_began_ns_ = 0, last_ns_ = 0;
    std::optional<Error> trouble_;
    std::atomic<bool> failed_{false};
    bool finished_ = false;

    std::thread thread_;
    std::mutex stop_mutex_;
    std::condition_variable stop_;
    bool stopping_ = false;
};

} // namespace sinew::record
