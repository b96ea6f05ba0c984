#pragma once
#include "sinew/bus/bus.hpp"
#include "sinew/robot/joint.hpp"
#include "sinew/robot/pause.hpp"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace sinew::robot {

/// One bus of a robot with its joints: what goes out in an exchange, and whose the answers are. No heap once it is
/// made.
class Line
{
public:
    /// `whole`: a fault of one joint stops the robot; else that joint alone. `pause` is that of the loop.
    Line(std::unique_ptr<bus::Bus> bus, Duration period, bool whole, const Pause& pause)
        : bus_(std::move(bus)), period_(period), whole_(whole), pause_(pause)
    {
    }

    /// Before the first exchange; the joints must stay where they are.
    void set_joints(std::vector<Joint*> joints);
    bus::Bus& bus() { return *bus_; }
    std::span<Joint* const> joints() const { return joints_; }

    // ---- what goes out next ----

    void clear() { size_ = 0; }
    void add(Joint& joint, std::span<const wire::Request> requests);
    std::expected<void, Error> plan_read(Joint& joint, Depth depth);
    /// What a supervisor finds is carried out; a fault is returned, and nothing must be planned then.
    Finding begin_cycle(TimePoint now);
    /// Whether the places of some would be old when they are told where to hold. Once a cycle, before that.
    bool must_look_first(TimePoint now) const;
    void plan_first_look(TimePoint now);
    bool has_looked() const { return has_looked_; }
    /// The commands of all joints and what they measure, now and then all of it. A joint takes what is planned for
    /// told.
    void plan_cycle(TimePoint now);
    std::span<const wire::Request> requests() const { return std::span(requests_).first(size_); }
    std::span<const bus::Result> results() const { return std::span(results_).first(size_); }
    Joint& owner(std::size_t request) { return *owners_[request]; }

    /// Makes ready what a stop sends, at `at` at the latest; not while an exchange runs.
    void prepare_stop(TimePoint at);
    void note_the_stop(TimePoint now);
    void forget_where_it_held(TimePoint now);
    /// Whether a stop tells it no place where to hold then.
    bool tells_no_place(const Joint& joint, Joint::Places places, TimePoint at) const;
    /// What a cycle carries beside the commands, now and then: settings of a device that has started afresh, the rest
    /// of its state, and whether it has.
    enum class Beside : std::uint8_t { settings, full_state, reset_check };
    static constexpr std::array all_beside{Beside::settings, Beside::full_state, Beside::reset_check};
    static std::expected<wire::Requests, Error> plan(Joint& joint, Beside what);
    std::span<const wire::Request> stop_requests() const { return stop_requests_; }
    /// What it sends when nobody has looked at the joints for a while.
    std::span<const wire::Request> unseen_stop_requests() const { return unseen_stop_requests_; }
    /// Whom a stop tells. Who has stopped already holds, perhaps with a load, and is left alone.
    enum class Whom : std::uint8_t { all, owing };
    /// What somebody sends who cannot look himself: until that is too long ago, and then.
    struct BlindStop {
        std::span<const wire::Request> seen;
        TimePoint until{};
        std::span<const wire::Request> unseen;
    };
    BlindStop blind_stop(Whom whom, TimePoint now);

    // ---- the exchange ----

    void start();
    bool busy() const { return busy_; }
    /// After its end: what came back goes to the joints.
    void absorb(TimePoint now);
    /// What it took to look at all joints, each the last time that it answered.
    Duration exchange() const;
    void note_exchange(Duration time);
    /// What the supervisors find; limits and time-outs are seen to, a fault of the robot is returned.
    Finding judge(TimePoint now);

    bool is_lost() const { return bus_->link_trouble() != nullptr || bus_->losses() != losses_; }
    void forgive() { losses_ = bus_->losses(); }
    /// Of a robot that is enabled.
    void begin()
    {
        forgive();
        owes_stop_ = has_looked_ = false;
    }
    /// It was stopped while its link was lost, and has not heard of it yet.
    bool owes_stop() const { return owes_stop_; }
    void owe_stop(bool owes) { owes_stop_ = owes; }
    /// Once a stop has gone out: exchanges go on, and joints of which it was not acknowledged owe it.
    void close_stop();
    /// Whoever asks for another one only ends what runs, until the next is prepared.
    void end_stop();

    Duration period() const { return period_; } ///< 0: as the loop asks
    TimePoint due() const { return due_; }
    void set_due(TimePoint due) { due_ = due; }
    void begin_run(TimePoint at)
    {
        due_ = at;
        has_looked_ = false;
    }

private:
    friend class LoadOfLine; // load.cpp

    TimePoint collect_stop(std::vector<wire::Request>& into, Whom whom, Joint::Places places, TimePoint at) const;
    bool is_of_before_a_loss(const Joint& joint) const;
    void note_times();
    bool plan_group(TimePoint now);
    void add_extras(TimePoint now);
    Finding judge(Joint& joint, TimePoint now) const;
    bool obey(Joint& joint, const Finding& finding, TimePoint now);
    void look_after(Joint& joint, TimePoint now);

    std::unique_ptr<bus::Bus> bus_;
    Duration period_{};
    bool whole_ = true;
    const Pause& pause_;
    TimePoint due_{};
    TimePoint begun_at_{}, absorbed_at_{};
    Duration interval_{};
    Duration usual_gap_{}; ///< between two times that it is asked while it is not driven
    bool busy_ = false;
    bool has_looked_ = false; ///< for the cycle that comes
    bool owes_stop_ = false;
    std::uint64_t losses_ = 0, seen_losses_ = 0;
    TimePoint back_since_{}; ///< the link was there when an exchange began, after the latest loss that was seen
    std::vector<Joint*> joints_;
    std::vector<Joint*> group_; ///< ids 1 to 4 of an RMD bus
    std::vector<wire::Request> requests_;
    std::vector<bus::Result> results_;
    std::vector<Joint*> owners_; ///< nullptr: of the group
    std::size_t size_ = 0;
    std::size_t next_full_ = 0;
    std::vector<wire::Request> stop_requests_, unseen_stop_requests_, blind_stop_requests_, blind_unseen_requests_;
};

} // namespace sinew::robot
