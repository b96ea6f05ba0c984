#pragma once
#include "sinew/base/error.hpp"
#include "sinew/sim/real_time.hpp"

#include <expected>
#include <filesystem>
#include <memory>

namespace sinew::cli {

/// The file in which `sinew sim` keeps the flash of its devices. It is written whole beside its place and moved there
/// whenever a device has written its flash, so it is never torn, whenever the simulator is killed.
class SimFlash final : public sim::Visitor
{
public:
    /// Gives the devices what the file has, if it is there, and writes it. `bad_file` with line and column,
    /// `bad_argument` when it cannot be written. `first` is served before it each time; world and visitor must outlive
    /// it.
    static std::expected<std::unique_ptr<SimFlash>, Error> open(std::filesystem::path path, sim::World& world,
                                                                sim::Visitor& first);

    std::span<const link::Handle> handles() override { return first_->handles(); }
    void serve() override;

    /// The first error of all that was written.
    std::expected<void, Error> close();

private:
    SimFlash(std::filesystem::path path, sim::World& world, sim::Visitor& first)
        : path_(std::move(path)), world_(&world), first_(&first)
    {
    }
    std::expected<void, Error> write();

    std::filesystem::path path_;
    sim::World* world_;
    sim::Visitor* first_;
    std::uint64_t written_ = 0; ///< writes of the flash that the file has
    std::expected<void, Error> outcome_{};
};

} // namespace sinew::cli
