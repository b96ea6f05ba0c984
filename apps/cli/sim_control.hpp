#pragma once
#include "sinew/base/error.hpp"
#include "sinew/link/descriptor.hpp"
#include "sinew/sim/real_time.hpp"

#include <array>
#include <expected>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

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
    void serve_socket();
    void serve_prompt();
    void tell_lateness();

    sim::RealTimeSimulator* simulator_;
    bool prompts_;
    std::function<void()> on_quit_;
    link::Fd socket_;
    std::filesystem::path path_;
    std::array<link::Handle, 2> handles_{};
    std::string typed_;
    std::uint64_t late_told_ = 0;
};

/// One line for the simulator that runs, and its answer. `link_not_found` when none runs; `bad_argument` when several
/// do and no process id says which.
std::expected<std::string, Error> ask_simulator(std::optional<std::int64_t> pid, std::string_view line);

} // namespace sinew::cli
