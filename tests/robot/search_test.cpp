#include "tests/robot/rig.hpp"
#include "tests/support/random.hpp"

#include <algorithm>

/// Joints that look for their stop at random, to which random things happen: no shaft turns faster than it is homed, a
/// joint that is said to be at home is there, and one that is not does not turn on, nor press on its stop once it is
/// stopped. SINEW_PROGRAMS, SINEW_SEED and SINEW_PROGRAM are as for the random programs.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;
using sinew::test::Random;

constexpr double stop_deg = -90.0, home_deg_s = 30.0;
/// A stop gives way by its spring, and throws back what leaves it.
constexpr double fastest_deg_s = 2.0 * home_deg_s;

struct Kind {
    std::string_view bus, joint;
    double stall_a; ///< 0: its current tells nothing
};
constexpr Kind kinds[] = {
    {"family = \"nuri\"\nbit_rate = 115200\n", "", 0.0},
    {"family = \"rmd\"\n", "model = \"MG\"\nprofile = \"rmd-2.35\"\n", 7.8},
    {"family = \"rmd\"\n", "model = \"MG\"\nprofile = \"lk-2.35\"\n", 7.8},
    {"family = \"rmd\"\n", "model = \"MG\"\nprofile = \"myactuator-3\"\n", 7.8},
};

class Search
{
public:
    Search(Random random, bool shows)
        : random_(random), shows_(shows), kind_(kinds[random_.below(std::size(kinds))]), rig_(file_of(text()))
    {
        rig_.robot->buses().front()->set_tap([this](const bus::Tapped&) {
            fastest_deg_s_ = std::max(fastest_deg_s_, std::abs(units::deg(rig_.truth_rad_s("joint"))));
            while (happens_ > 0 && rig_.now() >= happens_at_) {
                --happens_;
                happen();
            }
        });
    }

    void run()
    {
        rig_.enable();
        happens_ = static_cast<int>(random_.below(4));
        happens_at_ = rig_.now() + time(0, 12'000);
        const auto homed = rig_.robot->home("joint", random_.one_in(3) ? time(10, 9'000) : 30s);
        happens_ = 0;
        const TimePoint ended_at = rig_.now();
        if (shows_)
            fmt::print("{:.3f} home: {}, at {:.2f} deg\n", seconds(rig_.now().time_since_epoch()), said(homed),
                       units::deg(rig_.truth_rad("joint")));
        if (homed) {
            ++found;
            if (std::abs(units::deg(rig_.truth_rad("joint")) - (stop_deg - home_deg_)) > 1.0)
                complain(fmt::format("is at {:.2f} deg and said to be at home", units::deg(rig_.truth_rad("joint"))));
        }
        if (fastest_deg_s_ > fastest_deg_s)
            complain(fmt::format("turned at {:.1f} deg/s", fastest_deg_s_));
        rig_.simulator->world().mend("b");
        rig_.simulator->world().mend("joint");
        wait(500ms); // nobody drives
        // Whoever loses his count as the routine ends follows his last target elsewhere: nobody looks at him any more.
        const bool is_undisturbed = ended_at - happened_at_ > 100ms;
        if (homed ? is_undisturbed : rig_.robot->enabled())
            rests("after its routine");
        if (homed)
            presses_no_more("after its routine");
        const auto stopped = rig_.robot->stop();
        if (stopped.front().outcome != Stopped::Outcome::confirmed)
            complain(fmt::format("did not confirm a stop: {}", to_sentence(stopped.front().why)));
        wait(200ms);
        rests("after a stop");
        presses_no_more("after a stop");
    }

    std::vector<std::string> complaints;
    int found = 0;

private:
    std::string text()
    {
        home_deg_ = random_.one_in(3) ? 0.0 : stop_deg;
        return fmt::format("version = 1\n[safety]\npolicy = \"hold\"\nstop_time_s = 0.15\n[bus.b]\n{}[joint.joint]\n"
                           "bus = \"b\"\nid = 1\n{}position_min_deg = -90\nposition_max_deg = 200\n"
                           "velocity_max_deg_s = 60\n[joint.joint.sim]\nstart_rad = {}\n"
                           "[joint.joint.plant]\nstop_min_deg = {}\n[joint.joint.home]\nroutine = \"stop\"\n"
                           "direction = -1\nposition_deg = {}\nvelocity_deg_s = {}\n",
                           kind_.bus, kind_.joint, units::rad(stop_deg + 1.0 + static_cast<double>(random_.below(200))),
                           stop_deg, home_deg_, home_deg_s);
    }
    void presses_no_more(std::string_view when)
    {
        const double current_a = std::abs(rig_.simulator->world().look("joint")->current_a);
        if (kind_.stall_a > 0.0 && current_a > 0.05 * kind_.stall_a)
            complain(fmt::format("presses on with {:.2f} A {}", current_a, when));
    }
    Joint& joint() { return *rig_.robot->find("joint"); }
    Duration time(std::uint64_t least_ms, std::uint64_t most_ms)
    {
        return std::chrono::milliseconds{least_ms + random_.below(most_ms - least_ms)};
    }

    /// On serial lines nothing is garbled: a command that passes its checksum all the same is carried out.
    void happen()
    {
        happens_at_ = rig_.now() + time(1, 3'000);
        sim::Fault fault{.bus = "b", .for_s = seconds(time(1, 700))};
        switch (random_.below(4)) {
        case 0:
            fault.kind = kind_.stall_a > 0.0 ? sim::FaultKind::drop_bytes : sim::FaultKind::delay_replies;
            fault.probability = 0.3;
            break;
        case 1:
            fault.kind = sim::FaultKind::delay_replies;
            fault.probability = 0.3;
            break;
        case 2:
            fault.kind = sim::FaultKind::unplug;
            fault.bus.clear();
            fault.joint = "joint";
            break;
        default:
            rig_.robot->request_stop();
            return;
        }
        if (shows_)
            fmt::print("{:.3f} fault {} for {:.3f} s, at {:.2f} deg\n", seconds(rig_.now().time_since_epoch()),
                       static_cast<int>(fault.kind), fault.for_s, units::deg(rig_.truth_rad("joint")));
        rig_.simulator->world().inject(fault);
        happened_at_ = rig_.now();
    }

    void wait(Duration time)
    {
        for (const TimePoint until = rig_.now() + time; rig_.now() < until;)
            rig_.simulator->clock().wait({}, until);
    }
    void rests(std::string_view when)
    {
        if (const double speed = rig_.truth_rad_s("joint"); std::abs(speed) > 0.05)
            complain(fmt::format("turns at {:.2f} rad/s {}", speed, when));
    }
    void complain(std::string says) { complaints.push_back(std::string(kind_.joint) + " " + std::move(says)); }

    Random random_;
    bool shows_;
    Kind kind_;
    double home_deg_ = 0.0; ///< what its stop is called
    Rig rig_;
    int happens_ = 0;                        ///< so much is still to happen
    TimePoint happens_at_{}, happened_at_{}; ///< the next, and the last fault
    double fastest_deg_s_ = 0.0;
};

TEST(Program, AJointThatLooksForItsStopWhateverHappensIsAtHomeOrAtRest)
{
    const auto programs = sinew::test::setting("SINEW_PROGRAMS", 500);
    const auto only = sinew::test::setting("SINEW_PROGRAM", ~std::uint64_t{0});
    const bool is_one = only != ~std::uint64_t{0};
    int found = 0, failures = 0;
    for (std::uint64_t i = is_one ? only : 0; i < (is_one ? only + 1 : programs) && failures < 10; ++i) {
        Search search(Random(fmt::format("search {}", i)), is_one);
        search.run();
        found += search.found;
        if (!search.complaints.empty()) {
            ADD_FAILURE() << "SINEW_SEED=" << sinew::test::seed() << " SINEW_PROGRAM=" << i << ": "
                          << fmt::format("{}", fmt::join(search.complaints, "; "));
            ++failures;
        }
    }
    fmt::print("{} searches, {} came home; SINEW_SEED={}\n", programs, found, sinew::test::seed());
    EXPECT_GT(found, is_one ? -1 : 0);
}

} // namespace
} // namespace sinew::robot::test
