#include "apps/cli/stop_devices.hpp"

#include "apps/cli/stop_programs.hpp"
#include "sinew/family/broadcast.hpp"

#include <algorithm>

namespace sinew::cli {
namespace {

class Asked
{
public:
    Asked(Session& session, std::span<const Device> devices, bool whole, bool keep_torque)
        : session_(session), devices_(devices), whole_(whole), keep_torque_(keep_torque)
    {
    }

    std::vector<Done> stop()
    {
        std::vector<Done> done = tell_all();
        see_to_rest(session_, own_);
        for (std::size_t i = 0; i < own_.size(); ++i)
            done[places_[i]].outcome = own_[i].outcome();
        return done;
    }

private:
    /// What programs did; of the others the outcome is still to come.
    std::vector<Done> tell_all()
    {
        const Undisturbed undisturbed;
        std::vector<Done> done;
        own_.reserve(devices_.size());
        for (const auto& device : devices_) {
            if (auto stopped = programs_.stop_holder(device.name, device.link, device.id)) {
                done.push_back(std::move(*stopped));
                continue;
            }
            places_.push_back(done.size());
            done.push_back({device.name, {}});
            tell_line(device);
            own_.emplace_back(session_, device, keep_torque_).tell();
        }
        // Nobody else waits for a port that will be free.
        for (auto& one : own_)
            if (!one.confirmed() && one.confirmed().error().code == Errc::link_busy) {
                wait_for_port(session_, programs_, one.device().link);
                one.tell();
            }
        return done;
    }

    /// By the family's message to all of a line, where that does what was asked, and to nobody else.
    void tell_line(const Device& device)
    {
        const auto all = stop_of_all(*device.family);
        const bool is_asked = whole_ && !keep_torque_ && all && all->mode == actuator::Mode::release;
        if (!is_asked || programs_.hold(device.link) || std::ranges::find(lines_, device.link) != lines_.end())
            return;
        lines_.push_back(device.link);
        (void)stop_line(session_, device); // each says for itself whether it heard
    }

    Session& session_;
    std::span<const Device> devices_;
    bool whole_, keep_torque_;
    Programs programs_;
    std::vector<Stopping> own_;       ///< that no program holds
    std::vector<std::size_t> places_; ///< of these among all
    std::vector<std::string> lines_;  ///< that were told as a whole
};

} // namespace

std::vector<Done> stop_devices(Session& session, std::span<const Device> devices, bool whole, bool keep_torque)
{
    return Asked(session, devices, whole, keep_torque).stop();
}

} // namespace sinew::cli
