#pragma once
#include "sinew/base/error.hpp"
#include "sinew/link/descriptor.hpp"
#include "sinew/record/pcapng.hpp"
#include "sinew/sim/real_time.hpp"

#include <array>
#include <expected>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// How people talk to a simulator that runs: at its own prompt, and from other processes through a socket in
/// `$XDG_RUNTIME_DIR/sinew` (else a folder of the user in /tmp), one for each simulator by its process id.
namespace sinew::cli {

/// The ears of a simulator that runs.
class SimControl final : public sim::Visitor
{
public:
    /// `link_failed` when the socket cannot be made. `prompt`: also read lines from stdin and answer on stdout.
    static std::expected<std::unique_ptr<SimControl>, Error> open(sim::RealTimeSimulator& simulator, bool prompt,
                                                                  std::function<void()> on_quit);
    ~SimControl() override;

    /// Says that it reads from stdin, if it does.
    void show_prompt();
    std::span<const link::Handle> handles() override { return handles_; }
    void serve() override;
    void hear(std::string_view sentence) override;

private:
    SimControl(sim::RealTimeSimulator& simulator, bool prompt, std::function<void()> on_quit)
        : simulator_(&simulator), prompts_(prompt), on_quit_(std::move(on_quit))
    {
    }
    /// Somebody who listens to one bus; each message to it is a piece of a pcapng file.
    struct Sniffer {
        link::Fd fd;
        std::string bus;
        record::PcapngWriter writer;
    };
    void serve_socket();
    void serve_visitor(link::Fd client, std::string_view line);
    std::expected<std::string, Error> begin_sniffing(std::string_view words);
    void pass_on(const sim::RealTimeSimulator::Passed& passed);
    void serve_prompt();
    void tell_lateness();

    sim::RealTimeSimulator* simulator_;
    bool prompts_;
    std::function<void()> on_quit_;
    link::Fd socket_;
    std::filesystem::path path_;
    std::vector<link::Handle> handles_; // the socket, the prompt, then those who wait
    std::vector<link::Fd> waiting_;     // connected, and their question is still to come
    std::string typed_;
    std::uint64_t late_told_ = 0;
    std::vector<Sniffer> sniffers_;
    record::Time zero_{}; // the time of day at the power-on of the world
};

/// A connection on which the simulator that runs this robot file tells what passes on a bus, as pieces of a pcapng
/// file, until it ends. `link_not_found` when none runs that has the bus; an empty bus is the only one.
std::expected<link::Fd, Error> sniff_simulator(const std::string& robot, std::string_view bus);

/// One line for the simulator that runs, and its answer. `link_not_found` when none runs; `bad_argument` when several
/// do and no process id says which.
std::expected<std::string, Error> ask_simulator(std::optional<std::int64_t> pid, std::string_view line);

} // namespace sinew::cli
