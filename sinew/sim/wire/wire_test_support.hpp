#pragma once
#include "sinew/sim/wire/station.hpp"

#include <algorithm>
#include <initializer_list>
#include <utility>
#include <vector>

/// What the tests of this room share: a device and a host that write down what they hear.
namespace sinew::sim::test {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

inline constexpr TimePoint zero{};

inline wire::Frame frame(std::initializer_list<std::uint8_t> bytes, std::uint32_t can_id = 0)
{
    wire::Frame out{.can_id = can_id, .size = static_cast<std::uint8_t>(bytes.size())};
    std::ranges::copy(bytes, out.data.begin());
    return out;
}

/// Requests are four bytes that begin with FF.
class FourBytes final : public wire::Protocol
{
public:
    wire::Scan find_request(std::span<const std::uint8_t> bytes, bool silent) const override
    {
        ++scans;
        const auto skip = static_cast<std::size_t>(std::ranges::find(bytes, 0xFF) - bytes.begin());
        if (bytes.size() - skip >= 4)
            return {skip, 4};
        if (patient && !silent)
            return {0, 0};
        return {silent ? bytes.size() : skip, 0};
    }
    wire::Scan find_reply(std::span<const std::uint8_t>, std::size_t, bool) const override { return {}; }
    const wire::MessageInfo* identify(const wire::Frame&, wire::Direction, const wire::Profile&) const override
    {
        return nullptr;
    }
    int addressee(const wire::Frame& request) const override { return request.data[1] == 0x55 ? -1 : request.data[1]; }
    bool answers(const wire::Frame&, const wire::MessageInfo&, const wire::Frame&, wire::Options) const override
    {
        return false;
    }
    std::expected<wire::Request, Error> probe(int) const override { return fail(Errc::unsupported, "none"); }

    mutable std::size_t scans = 0; ///< how often it was asked
    bool patient = false;          ///< keeps garbage until the line is silent
};

struct FakeStation final : Station {
    explicit FakeStation(std::uint32_t rate) : rate_now(rate) { heard.reserve(64); }

    void answered(TimePoint at) override
    {
        answered_at = at;
        if (later_rate != 0)
            rate_now = later_rate;
    }
    std::optional<Answer> hear(const wire::Frame& request, TimePoint at) override
    {
        heard.emplace_back(request, at);
        if (next_rate != 0)
            rate_now = next_rate;
        if (next_number != 0)
            number = next_number;
        return answer;
    }
    const wire::Protocol& protocol() const override { return *framing; }
    int id() const override { return number; }
    bool hears_all() const override { return curious; }
    std::uint32_t bit_rate() const override { return rate_now; }

    FourBytes own_framing;
    const FourBytes* framing = &own_framing; ///< stations with one framing share an ear
    std::uint32_t rate_now;
    int number = 0;
    bool curious = false;
    std::uint32_t next_rate = 0;  ///< from the next message on; 0: as it is
    int next_number = 0;          ///< from the next message on; 0: as it is
    std::uint32_t later_rate = 0; ///< once its answer is out; 0: as it is
    std::optional<Answer> answer;
    std::vector<std::pair<wire::Frame, TimePoint>> heard;
    TimePoint answered_at{};
};

struct FakeSerialHost final : SerialHost {
    explicit FakeSerialHost(std::uint32_t rate) : rate_now(rate) { heard.reserve(64); }

    std::uint32_t bit_rate() const override { return rate_now; }
    void on_bytes(std::span<const std::uint8_t> bytes, TimePoint at) override
    {
        for (const std::uint8_t byte : bytes)
            heard.emplace_back(byte, at);
    }
    Bytes bytes() const
    {
        Bytes out;
        for (const auto& [byte, at] : heard)
            out.push_back(byte);
        return out;
    }

    std::uint32_t rate_now;
    std::vector<std::pair<std::uint8_t, TimePoint>> heard;
};

struct FakeCanHost final : CanHost {
    explicit FakeCanHost(std::uint32_t rate) : rate_now(rate) { heard.reserve(64); }

    std::uint32_t bit_rate() const override { return rate_now; }
    void on_frame(const wire::Frame& received, TimePoint at) override { heard.emplace_back(received, at); }

    std::uint32_t rate_now;
    std::vector<std::pair<wire::Frame, TimePoint>> heard;
};

} // namespace sinew::sim::test
