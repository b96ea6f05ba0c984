#pragma once
#include "sinew/diagnosis/line.hpp"
#include "sinew/family/families.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

/// Finds the devices on a link: every id of every family at every bit rate that may be, likely places first. Nothing
/// but reads is sent, and none of them is anything but a read to a device that hears it at another bit rate or as
/// another family: an id for which there is no such read is left out and counted.
namespace sinew::diagnosis {

/// Some ids of one family at one bit rate.
struct Pass {
    const Family* family = nullptr;
    std::uint32_t bit_rate = 0; ///< 0: as the link stands
    wire::Range ids{};
    bool likely = false; ///< where devices are as a rule: at low ids
};

struct ScanPlan {
    std::vector<const Family*> families; ///< empty: all that the link can carry
    std::optional<std::uint32_t> bit_rate;
    std::optional<wire::Range> ids;
    bool all = false; ///< do not stop at the first bit rate with answers
};

struct Found {
    const Family* family = nullptr;
    std::uint32_t bit_rate = 0;
    int id = -1;
    std::string model;       ///< empty: the device does not say, or nobody documents it
    std::string_view line{}; ///< firmware line, where the answer tells it; empty: any
    Duration round_trip{};
};

/// The passes in their order: low ids at the rate that the link has and at those of delivery, the other ids there, then
/// all other rates from fast to slow, the low ids first. On CAN the rate of the link alone, unless one is named: a
/// frame at a wrong rate disturbs everybody on the bus.
std::vector<Pass> passes(const ScanPlan& plan, bool can, std::uint32_t link_bit_rate);

/// Those at the beginning where devices are as a rule: low ids, at the rate of the link and at those of delivery.
std::span<const Pass> likely_places(std::span<const Pass> passes);

/// How long a pass takes if nobody answers, and several of them. Of serial lines the wire alone decides: for each id
/// the bits of a question, the longest time that a device may take before it answers, and what an adapter adds. On CAN
/// twice the time of all questions, for on a bus with other traffic the silent ids are asked once more.
Duration expected_time(const Pass& pass);
Duration expected_time(std::span<const Pass> passes);

class Scanner
{
public:
    using Stopped = std::function<bool()>;
    using At = std::function<void(const Pass& pass, int id)>;

    /// The line must outlive the scanner.
    explicit Scanner(Line& line) : line_(line) {}

    /// All passes in turn. When somebody answered, that rate is finished with the family that did, and then it ends,
    /// unless `all`. Once answers have shown how fast the line is, the other ids are given no more time than those
    /// took, and one that is much slower may be talked over; with `all` everybody has the time that the manual allows.
    /// Adds to `found`, sorted by family, rate and id. Ends early, with what it has, when `stopped` says so.
    std::expected<void, Error> sweep(std::span<const Pass> passes, bool all, const Stopped& stopped, const At& at,
                                     std::vector<Found>& found);
    /// One pass. A rate that the link cannot have is passed over.
    std::expected<void, Error> run(const Pass& pass, const Stopped& stopped, const At& at, std::vector<Found>& found);

    /// Ids that could not be asked without harm to somebody else.
    std::size_t left_out() const { return left_out_; }

private:
    struct Asked {
        int id = -1;
        TimePoint at{};
    };

    /// Ids that were asked and did not answer.
    struct Silent {
        std::vector<int> ids;
        bool noise = false; ///< somebody else talks: an answer may have gone to another master
    };

    std::expected<void, Error> run_can(const Pass& pass, std::vector<Found>& found);
    std::expected<Silent, Error> ask_all(const Pass& pass, const wire::Profile& line, std::span<const int> ids,
                                         Duration wait, std::vector<Found>& found);
    std::expected<void, Error> run_serial(const Pass& pass, const Stopped& stopped, const At& at,
                                          std::vector<Found>& found);
    std::expected<void, Error> look_again(const Pass& pass, std::span<const Asked> asked, const Stopped& stopped,
                                          std::vector<Found>& found);
    std::expected<void, Error> ask(const Family& family, int id, Duration wait, bool& noise, std::vector<Found>& found);
    std::expected<void, Error> get_to_know(const Family& family, int id);
    std::string model_of(const Family& family, int id);
    Duration wait_for(const Family& family) const;

    Line& line_;
    bool hurries_ = true;
    std::size_t left_out_ = 0;
    int measured_ = 0;
    Duration slowest_{}; ///< the most that link and adapter added to an answer
    int second_looks_ = 0;
};

} // namespace sinew::diagnosis
