#pragma once
#include "sinew/robot/line.hpp"
#include "sinew/robot/robot.hpp"

#include <atomic>
#include <optional>
#include <string>

namespace sinew::robot {

/// What a `Robot` is made of. For the files of this room only.
class Core
{
public:
    ~Core();
    static std::expected<std::unique_ptr<Core>, Error> make(config::RobotFile file, const link::Links& links,
                                                            link::Clock& clock, const OpenOptions& options);

    std::expected<void, Error> enable();
    std::expected<void, Error> cycle();
    /// `each` returns whether to go on.
    std::expected<void, Error> run(Duration period, const std::function<bool()>& each, TimePoint until);
    std::expected<void, Error> home(std::span<Joint* const> all, Duration within);
    std::expected<void, Error> read(Depth depth);
    std::vector<Stopped> stop(const std::string& why);
    void request_stop() noexcept;

    config::RobotFile file;
    ResolvedRobot resolved;
    link::Clock* clock = nullptr;
    Incidents incidents;
    std::vector<Joint> joints;
    std::vector<std::unique_ptr<Line>> lines;
    std::vector<bus::Bus*> buses;
    bool enabled = false;
    bool leaving = false; ///< `run` ends with this turn
    std::optional<Error> fault;
    Pause pause; ///< of the loop

private:
    static constexpr int most_tries = 4; ///< of an exchange in which one answer may be missing, or not be believed
    std::expected<std::unique_ptr<bus::Bus>, Error> open_bus(const config::Bus& bus, const link::Links& links,
                                                             const OpenOptions& options);
    // enable.cpp
    std::expected<void, Error> hold_all();
    void tell_owed_stop(Line& line);
    std::expected<void, Error> check_no_stop() const;
    std::expected<void, Error> look_before_enabling();
    std::expected<void, Error> read_where_they_are();
    std::expected<void, Error> let_go_of_all();
    std::expected<void, Error> take_hold();
    std::expected<void, Error> bring_links_back();
    std::expected<void, Error> compare_models();
    std::expected<void, Error> exchange(std::string_view what);
    template <class Plan>
    std::expected<void, Error> exchange_all(std::string_view what, Plan plan);
    std::expected<void, Error> switch_all_on();

    // home.cpp
    struct Homeward;
    static std::expected<void, Error> send_home(Homeward& one);
    std::expected<void, Error> find_stops(std::span<Joint* const> all, TimePoint until);
    std::unexpected<Error> hold_after(std::span<Joint* const> all, Error why);

    std::expected<void, Error> read_only();
    void let_a_stop_out();
    std::expected<void, Error> look_at(Line& line);
    std::expected<void, Error> look_at_all();
    std::expected<void, Error> look_first();
    std::expected<void, Error> end_exchanges();
    void exchange_lines();
    std::unexpected<Error> stop_for(Error why);
    /// Once for every thread that drives.
    void ask_for_real_time(); // real_time.cpp
    // stop.cpp
    void send_stop();
    bool heed_another_stop();
    bool hold_what_was_braked(std::vector<Stopped>& outcomes);
    void verify(std::vector<Stopped>& outcomes, TimePoint end);
    std::vector<Joint*> hold_anew(std::vector<Joint*> left);
    void relieve(std::vector<Stopped>& outcomes, TimePoint end);
    struct Look;
    static bool is_worth_asking(const Joint& joint, const Stopped& outcome);
    static bool is_asked(const Joint& joint, const Stopped& outcome, const Look& look);
    void ask(Line& line, Joint& joint, Stopped& outcome, const Look& look);
    void hear(Joint& joint, Stopped& outcome, const Look& look);
    bool ask_again(std::vector<Stopped>& outcomes, int number, bool commands);
    static bool has_obeyed(const Joint& joint, Mode told, TimePoint since);
    void conclude(std::vector<Stopped>& outcomes);
    void tell_owed_stops();
    void plan_owed_stops(bool at_once); ///< else not at every look
    void hear_of_owed_stops(TimePoint begun);
    Stopped& outcome_of(const Joint& joint, std::vector<Stopped>& outcomes) const;
    // guarding.cpp
    std::expected<void, Error> hand_over(std::size_t line);
    std::expected<void, Error> hand_over();
    std::expected<void, Error> heed_the_guardian();
    void tell_the_guardian(Line& line);
    void tell_the_guardian_of_a_stop(std::span<const Stopped> outcomes);
    void show_life();
    void drive();
    void rest();

    /// Until whoever drives has carried it out, or has told whoever enables.
    std::atomic<bool> stop_asked_{false};
    bool is_stopping_ = false; ///< its frames are out, and it is not over
    std::uint64_t driver_ = 0; ///< the thread that asked last
    Guardian* guardian_ = nullptr;
    std::vector<std::string> uris_;                   ///< of the lines
    std::vector<std::optional<std::uint64_t>> known_; ///< losses of each line when its guardian got the descriptor
};

} // namespace sinew::robot
