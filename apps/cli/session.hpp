#pragma once
#include "apps/cli/device.hpp"
#include "apps/cli/interrupt.hpp"
#include "sinew/actuator/driver.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/link/links.hpp"
#include "sinew/record/replay.hpp"
#include "sinew/sim/links.hpp"

#include <map>
#include <memory>
#include <string>

/// Links, buses and time of one run of the command.
namespace sinew::cli {

/// Whether a word names a link and not a joint.
bool is_link(std::string_view word);

/// `bad_argument` where `--sim` stands beside a link, which has no robot file to simulate.
std::expected<void, Error> no_sim_for(const Words& words, std::string_view link);

/// The link with a bit rate for families whose ports must be given one, where it says none.
std::string with_bit_rate(const std::string& link, const Family& family, std::uint32_t bit_rate = 0);

class Session
{
public:
    Session();
    /// The bus of a device, opened at its first use; it knows the device afterwards, and opens its link again when that
    /// was lost. Two families cannot share a link.
    std::expected<bus::Bus*, Error> bus_of(const Device& device);
    /// A link of the system, of the simulator or of a recording with the clock that it needs. All links of a session
    /// share one clock: `bad_argument` for one in virtual time beside a real one.
    std::expected<link::AnyLink, Error> open(const std::string& link);
    /// Of the links that are open; the real one as long as there is none.
    link::Clock& clock() { return *clock_; }
    /// Whether that is another one.
    bool in_virtual_time() const { return clock_ != &real_; }
    /// All that are open.
    std::vector<bus::Bus*> buses() const;

private:
    struct Open {
        std::string link;
        const Family* family;
        std::unique_ptr<bus::Bus> bus;
        std::unique_ptr<StopOnInterrupt> stop;
    };
    link::RealClock real_;
    link::Clock* clock_ = &real_;
    sim::Worlds worlds_; // goes after the links that lead into it
    record::Replays replays_;
    link::Links links_;
    std::vector<Open> open_;
};

/// What `--link BUS=LINK` gives, by bus: links that take the place of those in the file.
std::expected<std::map<std::string, std::string>, Error> given_links(const Words& words, const config::RobotFile& file);

/// The device that TARGET and the options name. Nothing is opened.
std::expected<Device, Error> target(const Words& words);
/// That device, or all joints of the robot file where there is no TARGET.
std::expected<std::vector<Device>, Error> targets(const Words& words);
/// All joints of the robot file that the options name.
std::expected<std::vector<Device>, Error> whole_robot(const Words& words);
/// The same of this file.
std::expected<std::vector<Device>, Error> robot_at(const Words& words, const std::string& path);
/// The joints of a robot file, with the links that stand in it (empty: none).
std::expected<std::vector<Device>, Error> devices_in(const std::string& path);
/// With `--sim` those of the simulator, else the links of the command line, else those of the robot file;
/// `bad_argument` where none says one.
std::expected<void, Error> give_links(const Words& words, std::vector<Device>& devices);
/// Time-outs allow for a host that schedules fairly; SINEW_PATIENCE is for one that does not.
std::expected<bus::Settings, Error> bus_settings();

/// The robot file that the options or the environment name.
std::optional<std::string> robot_path(const Words& words);
/// Whether they name one.
bool has_robot(const Words& words);

/// Asks a device for its model where the words gave none and its scales depend on it. The device stays without a spec
/// when it says a model that nobody documents.
std::expected<void, Error> find_model(Device& device, bus::Bus& bus);

/// A device that can be driven.
struct Driven {
    Device device;
    bus::Bus* bus = nullptr;
    std::unique_ptr<actuator::Driver> driver;
    actuator::State state{};
};

/// Opens the bus and makes the driver; finds the model if it must.
std::expected<Driven, Error> drive(Session& session, Device device);

/// Sets the device to what the robot file says of its run-time settings.
std::expected<void, Error> set_up(Driven& driven);

/// Carries out what a driver planned, and puts what comes back into the state. The first failure ends it.
std::expected<void, Error> carry_out(Driven& driven, const wire::Requests& requests);
std::expected<void, Error> read_state(Driven& driven, actuator::Depth depth);
/// Stays where it is, with torque. Where the protocol can hold without knowing the position nothing is read first.
std::expected<void, Error> hold(Driven& driven);

/// One request; no values where no answer is due.
std::expected<wire::Values, Error> ask(bus::Bus& bus, const wire::Request& request);

/// Waits until `until` or until Ctrl-C; links that were lost come back meanwhile.
void wait_until(Session& session, TimePoint until);

} // namespace sinew::cli
