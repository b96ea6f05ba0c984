#pragma once
#include "sinew/diagnosis/doctor.hpp"
#include "sinew/diagnosis/line.hpp"
#include "sinew/diagnosis/scanner.hpp"
#include "sinew/link/uri.hpp"

#include <optional>

/// What the checks of an examination share. For this room only.
namespace sinew::diagnosis {

/// A device that was expected or found.
struct Patient {
    int id = -1;
    std::string joint; ///< empty: not of the robot file
    std::optional<DeviceSpec> spec;
    bool expected = false;
    bool present = false;                     ///< answers at the rate of the line
    std::optional<std::uint32_t> elsewhere{}; ///< the rate at which it answers instead
    bool doubled = false;                     ///< two of this id: what it says means nothing

    /// The robot file says that it never answers.
    bool silent() const
    {
        const auto* sam = spec ? std::get_if<sam::Spec>(&*spec) : nullptr;
        return sam != nullptr && sam->profile.response_level > 1;
    }
};

class Walk
{
public:
    Walk(const Subject& asked, const Surroundings& around, Examination& into);

    const Subject& subject;
    std::optional<link::Uri> uri;
    const Family* family = nullptr; ///< as asked for, or as found
    std::unique_ptr<Line> line;     ///< none until the port is open
    std::vector<Patient> patients;  ///< in the order of the robot file

    // ---- findings ----

    /// All is well, for this reason.
    void fine(std::string_view check, std::string evidence);
    /// Something is found. An empty `next` is that of the kind.
    Finding& add(std::string_view kind, std::string evidence, std::string next = {});
    Finding& add(const Patient& patient, std::string_view kind, std::string evidence, std::string next = {});
    /// Whether something that is worse than a note was found of this kind's check.
    bool has(std::string_view kind) const;
    void progress(std::string_view text) const;
    bool stopped() const { return around_.stopped(); }
    link::Adapter look_at(const std::string& device) const { return link::look_at_adapter(device, around_.roots); }
    /// Of a link that is one; nothing for others.
    std::optional<std::expected<link::CanInterface, Error>> can_interface() const
    {
        if (!uri || uri->scheme != "can")
            return std::nullopt;
        return around_.can_interface(uri->target);
    }
    /// Of the open line, which there must be.
    link::Report report() const { return uri ? link::report_of(*uri, line->link(), around_.roots) : link::Report{}; }
    std::string who_holds(const std::string& device) const { return link::who_holds(device, around_.roots); }
    std::expected<Opened, Error> open() const { return around_.open(subject.link); }
    std::size_t count() const { return into_.findings.size(); }
    void finish(); ///< reports what has been added since

    // ---- questions ----

    std::vector<Patient*> present();
    std::vector<Patient*> missing();  ///< that should answer
    std::vector<Patient*> readable(); ///< that are present, and one only
    /// "id 3 (elbow)"
    static std::string name_of(const Patient& patient);
    /// "ids 1, 2 and 5"
    static std::string names_of(std::span<Patient* const> patients);

    /// Sends a read in a way that nobody takes for more; nothing when there is none.
    std::expected<std::optional<Look>, Error> read(const wire::Request& plain, Duration wait);
    /// Asks a device whether it is there, more than once.
    std::expected<bool, Error> answers(const Family& of, int id, const DeviceSpec* spec, Duration wait);
    /// The answer to a message without fields.
    template <class M>
    std::expected<std::optional<wire::ReplyOf<M>>, Error> call(const Patient& patient);
    /// The reads that make up the whole state of a device.
    std::vector<wire::Request> state_reads(const Patient& patient) const;
    static Patient patient_of(const Found& found);
    /// For the first byte of an answer: long enough for the adapters of nearly everybody.
    static Duration quick(const Family& of) { return of.response_time.most + std::chrono::milliseconds{30}; }
    /// Long enough for every device and adapter.
    Duration patience() const { return family->response_time.most + std::chrono::milliseconds{150}; }

private:
    Finding& put(Finding finding);

    const Surroundings& around_;
    Examination& into_;
    std::size_t reported_ = 0;
};

template <class M>
std::expected<std::optional<wire::ReplyOf<M>>, Error> Walk::call(const Patient& patient)
{
    const auto options = patient.spec ? options_of(*patient.spec) : wire::Options{};
    const auto request = wire::make_request(patient.id, M{}, options);
    if (!request)
        return std::nullopt;
    const auto look = read(*request, patience());
    if (!look)
        return std::unexpected(look.error());
    if (!*look || !(*look)->reply)
        return std::nullopt;
    const auto said = wire::decode_reply<M>(*(*look)->reply, options);
    return said ? std::optional(said->message) : std::nullopt;
}

using Checked = std::expected<void, Error>; ///< the error of a link that is lost

// Of the port, without a line: they cannot lose it. port.cpp
void check_device_file(Walk& walk);
void check_permission(Walk& walk);
void check_port(Walk& walk);
void check_adapter(Walk& walk);

// Of the line: wires.cpp, rates.cpp, presence.cpp
Checked check_traffic(Walk& walk);
Checked check_echo(Walk& walk);
Checked check_bit_rate(Walk& walk);
Checked check_devices(Walk& walk);

// Of the devices: duplicates.cpp, settings.cpp, health.cpp
Checked check_duplicates(Walk& walk);
Checked check_response_level(Walk& walk);
Checked check_scales(Walk& walk);
Checked check_health(Walk& walk);
Checked check_round_trips(Walk& walk);

// Of the adapter, after all that: port.cpp
Checked check_counters(Walk& walk);

} // namespace sinew::diagnosis
