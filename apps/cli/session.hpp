#pragma once
#include "apps/cli/device.hpp"
#include "apps/cli/interrupt.hpp"
#include "sinew/actuator/driver.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/link/links.hpp"
#include "sinew/record/replay.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/sim/links.hpp"

#include <map>
#include <memory>
#include <string>

/// Links, buses and time of one run of the command.
namespace sinew::cli {

/// Whether a word names a link and not a joint.
bool is_link(std::string_view word);

/// Whether a word names a robot file, where a link might stand as well.
bool is_robot_file(std::string_view word);

/// `bad_argument` where `--family` stands beside a robot file, which says it.
std::expected<void, Error> no_family_for(const Words& words);

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
    /// For verbs that move a device: starts the guardian that holds it when this program dies, before anything is
    /// opened. Devices that are simulated in here, or replayed, end with the program and have none. Ctrl-Z is a Ctrl-C
    /// from now on.
    std::expected<void, Error> guard(const Device& device);
    /// nullptr: none.
    robot::Guardian* guardian() { return guardian_ ? &*guardian_ : nullptr; }
    /// Shows life, and takes what the guardian wants (`sinew stop` elsewhere), or its death, for a Ctrl-C.
    void heed_guardian();
    /// A link of the system, of the simulator or of a recording with the clock that it needs. All links of a session
    /// share one clock: `bad_argument` for one in virtual time beside a real one.
    std::expected<link::AnyLink, Error> open(const std::string& link);
    /// Of the links that are open; the real one as long as there is none.
    link::Clock& clock() { return *clock_; }
    /// Whether that is another one.
    bool in_virtual_time() const { return clock_ != &real_; }
    /// All that are open.
    std::vector<bus::Bus*> buses() const;
    /// Of recordings: what they have told so far (`record::Replays::given`).
    std::uint64_t replayed() const { return replays_.given(); }

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
    std::optional<robot::Guardian> guardian_;
    std::vector<Open> open_;
};

/// What `--link BUS=LINK` gives, by bus: links that take the place of those in the file. `bad_argument` beside `--sim`.
std::expected<std::map<std::string, std::string>, Error> given_links(const Words& words, const config::RobotFile& file);

/// The device that TARGET and the options name. Nothing is opened.
std::expected<Device, Error> target(const Words& words);
/// That device, or all joints of the robot file where there is no TARGET.
std::expected<std::vector<Device>, Error> targets(const Words& words);
/// `bad_argument` where that is one of a recording. The functions here say it for verbs that act.
std::expected<void, Error> check_live(const Device& device);
/// That a robot file has none, for verbs that need some.
std::unexpected<Error> no_joints(const std::string& path);
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
/// For a command that moves something; before threads and links. It also stops one that hangs, after `patience` or,
/// where that is less than what a program of this machine may need, after that.
std::expected<robot::Guardian, Error> start_guardian(std::optional<Duration> patience = {});

/// The robot file that the options or the environment name.
std::optional<std::string> robot_path(const Words& words);
/// Whether they name one.
bool has_robot(const Words& words);

/// Asks a device for its model where the words gave none and its scales depend on it. The device stays without a spec
/// when it says a model that nobody documents.
std::expected<void, Error> find_model(Device& device, bus::Bus& bus);

struct Driven;
class DeviceRecord;

/// What the guardian would send to one device: to hold, or to brake where that needs a place, which may be old when
/// this program has died. It answers for this device alone, and the name of its link says so: what is behind its # is
/// the id. One device of a session at a time.
class MotionGuard
{
public:
    MotionGuard(robot::Guardian& guardian, const Device& device);
    /// After every look, also one that failed, and once before anything moves. An error where the guardian cannot reach
    /// the link. One that is lost is let go there too, so that its adapter may come back under its name.
    std::expected<void, Error> update(Driven& driven);

private:
    robot::Guardian& guardian_;
    std::unique_ptr<actuator::Driver> stopper_; ///< the one that drives must not take what was never sent for sent
    actuator::Command stop_;
    std::string link_;
    std::optional<std::uint64_t> known_; ///< losses of the link when it was handed over
};

/// A device that can be driven.
struct Driven {
    Device device;
    bus::Bus* bus = nullptr;
    std::unique_ptr<actuator::Driver> driver;
    actuator::State state{};
    std::unique_ptr<MotionGuard> guard; ///< nullptr: nobody stops it when this program dies
    DeviceRecord* record = nullptr;     ///< nullptr: it is not recorded
};

/// Opens the bus and makes the driver; finds the model if it must.
std::expected<Driven, Error> drive(Session& session, Device device);

/// Sets the device to what the robot file says of its run-time settings.
std::expected<void, Error> set_up(Driven& driven);

/// Carries out what a driver planned, and puts what comes back into the state. The first failure ends it.
std::expected<void, Error> carry_out(Driven& driven, const wire::Requests& requests);
std::expected<void, Error> read_state(Driven& driven, actuator::Depth depth);
/// Whether the same words may be understood the next time: the line is there, and the answer is missing or spoiled.
bool may_pass(Errc code);

/// Does it once more where it was not confirmed and that may pass, up to three times in all: for what changes nothing
/// when it is carried out twice. Returns what came last.
template <class Do>
auto until_confirmed(const Do& once, int attempts = 3)
{
    auto done = once();
    for (int again = 1; !done && may_pass(done.error().code) && again < attempts; ++again)
        done = once();
    return done;
}

/// One request; no values where no answer is due.
std::expected<wire::Values, Error> ask(bus::Bus& bus, const wire::Request& request);

/// Waits until `until` or until Ctrl-C; links that were lost come back meanwhile.
void wait_until(Session& session, TimePoint until);

} // namespace sinew::cli
