#pragma once
#include "apps/cli/probes.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/family/families.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// Finds the devices on a link: every id of every family at every bit rate that may be, likely places first. Nothing
/// but reads is sent, and none of them is anything but a read to a device that hears it at another bit rate or as
/// another family: an id for which there is no such read is left out and counted.
namespace sinew::cli {

/// One family at one bit rate.
struct Pass {
    const Family* family = nullptr;
    std::uint32_t bit_rate = 0; ///< 0: as the link stands
    wire::Range ids{};
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

/// The passes in their order: the rate that the link has, the rates of delivery, then all others from fast to slow. On
/// CAN the rate of the link alone, unless one is named: a frame at a wrong rate disturbs everybody on the bus.
std::vector<Pass> passes(const ScanPlan& plan, bool can, std::uint32_t link_bit_rate);

/// How long a pass takes if nobody answers.
Duration expected_time(const Pass& pass);

class Scanner
{
public:
    /// The clock must outlive the scanner.
    Scanner(link::AnyLink link, link::Clock& clock);
    ~Scanner();

    /// Carries out one pass and adds to `found`. Ends early, with what it has, when `stopped` says so. A rate that the
    /// link cannot have is passed over.
    std::expected<void, Error> run(const Pass& pass, const std::function<bool()>& stopped,
                                   const std::function<void(int id)>& at, std::vector<Found>& found);

    std::uint32_t link_bit_rate() const;
    bool can() const;
    /// Ids that could not be asked without harm to somebody else.
    std::size_t left_out() const { return left_out_; }

private:
    struct Shared;
    std::expected<void, Error> run_can(const Pass& pass, std::vector<Found>& found);
    std::expected<void, Error> run_serial(const Pass& pass, const std::function<bool()>& stopped,
                                          const std::function<void(int id)>& at, std::vector<Found>& found);
    struct Look;
    std::expected<Look, Error> look(const wire::Request& request, const Family& family, const bus::Settings& settings);
    std::expected<bool, Error> ask(const Family& family, int id, const bus::Settings& settings, bool& noise,
                                   std::vector<Found>& found);
    std::string model_of(const Family& family, int id);
    std::unique_ptr<bus::Bus> make_bus(const Family& family, const bus::Settings& settings);

    std::shared_ptr<Shared> link_;
    link::Clock& clock_;
    Audience audience_;
    std::size_t left_out_ = 0;
};

} // namespace sinew::cli
