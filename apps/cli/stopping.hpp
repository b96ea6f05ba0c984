#pragma once
#include "apps/cli/rest.hpp"

#include <span>

/// What `stop` does to devices: all of them are told first, and then it looks whether they stand still.
namespace sinew::cli {

struct Told {
    std::string says;       ///< what it does now
    bool confirmed = false; ///< it was seen at rest, or the program that moves it said so
};

struct Done {
    std::string name;
    std::expected<Told, Error> outcome;
    bool perhaps = false; ///< of a failure: it was told, and may have obeyed
};

/// One device on its way to rest.
class Stopping
{
public:
    Stopping(Session& session, Device device, bool keep_torque)
        : session_(session), device_(std::move(device)), keep_torque_(keep_torque)
    {
    }

    /// Once; nobody looks. The bus is opened at the first time.
    void tell();
    /// Once: where it is, and where the protocol says so whether its torque is off.
    void look();
    /// Nothing more is to be learned: it was seen at rest as it was asked, or cannot be told, or asked.
    bool is_over() const;
    /// A stop changes nothing when it is carried out twice, and one lost frame must not leave a motor running.
    bool is_worth_another_word() const;

    const Device& device() const { return device_; }
    /// So often it was let go of what it may have pressed on, heard or not.
    int reliefs() const { return reliefs_; }
    /// Of the latest telling: an error where the device was not reached, or did not confirm what it should have.
    const std::expected<void, Error>& confirmed() const { return telling_.confirmed; }
    std::expected<Told, Error> outcome() const;

private:
    Telling tell_to_let_go();
    void relieve();
    bool is_off() const;
    bool is_obeyed() const;
    std::string done() const;
    Error not_seen_at_rest() const;

    Session& session_;
    Device device_;
    bool keep_torque_;
    std::optional<Driven> driven_;
    Telling telling_;
    bool acknowledges_ = false;    ///< a release
    bool is_mute_ = false;         ///< set to answer nothing
    int unanswered_ = 0;           ///< looks in a row
    std::optional<Error> trouble_; ///< of the latest look
    actuator::State before_{};     ///< what it saw
    std::optional<Standing> standing_;
    bool stands_ = false;
    /// Of what it may have pressed on.
    enum class Relief : std::uint8_t { due, done, given_up } relief_ = Relief::due;
    int reliefs_ = 0; ///< so often it was told
};

/// Looks at all of them, time and again, until each is seen at rest or given up; a Ctrl-C ends it.
void see_to_rest(Session& session, std::span<Stopping> all);

/// All devices of a line at once, where the family has a message for that.
std::expected<Told, Error> stop_line(Session& session, const Device& everybody);

} // namespace sinew::cli
