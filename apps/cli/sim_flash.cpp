#include "apps/cli/sim_flash.hpp"

#include "apps/cli/new_file.hpp"
#include "sinew/config/flash_file.hpp"

#include <utility>

namespace sinew::cli {

std::expected<std::unique_ptr<SimFlash>, Error> SimFlash::open(std::filesystem::path path, sim::World& world,
                                                               sim::Visitor& first)
{
    std::unique_ptr<SimFlash> flash(new SimFlash(std::move(path), world, first));
    std::error_code unknown;
    if (std::filesystem::exists(flash->path_, unknown)) {
        const auto file = config::read_flash_file(flash->path_);
        if (!file)
            return std::unexpected(file.error());
        if (const auto restored = world.restore(*file); !restored)
            return std::unexpected(restored.error());
    }
    if (const auto written = flash->write(); !written)
        return std::unexpected(written.error());
    return flash;
}

void SimFlash::serve()
{
    first_->serve();
    if (world_->flash_writes() == written_)
        return;
    if (auto written = write(); !written && outcome_)
        outcome_ = std::move(written);
}

std::expected<void, Error> SimFlash::write()
{
    written_ = world_->flash_writes();
    auto file = NewFile::make(path_);
    if (!file)
        return std::unexpected(file.error());
    if (auto done = file->write(world_->flash()); !done)
        return done;
    return file->keep();
}

std::expected<void, Error> SimFlash::close()
{
    serve();
    return outcome_;
}

} // namespace sinew::cli
