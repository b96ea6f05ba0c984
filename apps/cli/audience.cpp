#include "apps/cli/audience.hpp"

#include <algorithm>
#include <array>

namespace sinew::cli {
namespace {

constexpr std::size_t bits_per_byte = 10;
constexpr std::size_t longest_frame = wire::Frame::capacity;
/// Two oscillators are off by no more than this against each other where a UART is to work at all, in these steps.
constexpr double clock_error_max = 0.03;
constexpr double clock_error_step = 0.005;

/// Takes the requests off the front of the bytes; true when one of them is more than a read.
bool takes_harm(const Family& family, std::vector<std::uint8_t>& bytes, bool silent)
{
    std::span<const std::uint8_t> rest = bytes;
    bool harm = false;
    for (;;) {
        const auto scan = family.protocol->find_request(rest, silent);
        if (scan.size == 0) {
            rest = rest.subspan(std::min(scan.skip, rest.size()));
            break;
        }
        wire::Frame frame{.size = static_cast<std::uint8_t>(scan.size)};
        std::copy_n(rest.begin() + static_cast<std::ptrdiff_t>(scan.skip), scan.size, frame.data.begin());
        rest = rest.subspan(scan.skip + scan.size);
        for (const auto* line : family.profiles) {
            const auto* message = family.protocol->identify(frame, wire::Direction::request, *line);
            harm = harm || (message != nullptr && message->info.access != wire::Access::read);
        }
    }
    bytes.erase(bytes.begin(), bytes.end() - static_cast<std::ptrdiff_t>(rest.size()));
    return harm;
}

std::vector<std::uint32_t> all_rates()
{
    std::vector<std::uint32_t> out;
    for (const auto* family : families())
        if (!family->can)
            for (const auto& rate : family->bit_rates)
                if (std::ranges::find(out, rate.bps) == out.end())
                    out.push_back(rate.bps);
    return out;
}

} // namespace

std::vector<std::uint8_t> hear_at(std::span<const std::uint8_t> bytes, double sent_bps, double heard_bps,
                                  bool takes_broken_bytes)
{
    std::array<bool, bits_per_byte * longest_frame> levels{};
    std::size_t count = 0;
    for (const auto byte : bytes) {
        levels[count++] = false;
        for (int bit = 0; bit < 8; ++bit)
            levels[count++] = (byte >> bit & 1) != 0;
        levels[count++] = true;
    }
    // Time counts in bits as they were sent.
    const double bit = sent_bps / heard_bps;
    const auto level = [&](double time) {
        return time >= static_cast<double>(count) || levels[static_cast<std::size_t>(time)];
    };
    std::vector<std::uint8_t> out;
    double ready = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        const bool falls = !levels[i] && (i == 0 || levels[i - 1]);
        const auto fall = static_cast<double>(i);
        if (!falls || fall < ready || level(fall + 0.5 * bit))
            continue;
        unsigned byte = 0;
        for (int n = 0; n < 8; ++n)
            byte |= static_cast<unsigned>(level(fall + (1.5 + n) * bit)) << n;
        ready = fall + 9.5 * bit;
        if (level(ready) || takes_broken_bytes)
            out.push_back(static_cast<std::uint8_t>(byte));
    }
    return out;
}

Audience::Audience()
{
    constexpr int steps = static_cast<int>(clock_error_max / clock_error_step + 0.5);
    for (const auto* family : families()) {
        if (family->can)
            continue;
        for (const auto& rate : family->bit_rates)
            for (int step = -steps; step <= steps; ++step)
                for (const bool broken : {false, true})
                    listeners_.push_back({family, rate.bps * (1.0 + step * clock_error_step), broken});
    }
}

bool Audience::harmless(const wire::Frame& frame, std::uint32_t bit_rate) const
{
    if (bit_rate == 0)
        return std::ranges::all_of(all_rates(), [&](std::uint32_t rate) { return harmless(frame, rate); });
    for (const auto& listener : listeners_) {
        const auto heard = hear_at(frame.bytes(), bit_rate, listener.bit_rate, listener.takes_broken_bytes);
        if (heard.empty())
            continue;
        auto alone = heard;
        auto after = listener.remembers;
        after.insert(after.end(), heard.begin(), heard.end());
        auto then_silent = after;
        if (takes_harm(*listener.family, alone, true) || takes_harm(*listener.family, after, false) ||
            takes_harm(*listener.family, then_silent, true))
            return false;
    }
    return true;
}

void Audience::hear(const wire::Frame& frame, std::uint32_t bit_rate)
{
    for (auto& listener : listeners_) {
        if (bit_rate == 0) {
            listener.remembers.clear(); // what it heard is not known
            continue;
        }
        const auto heard = hear_at(frame.bytes(), bit_rate, listener.bit_rate, listener.takes_broken_bytes);
        listener.remembers.insert(listener.remembers.end(), heard.begin(), heard.end());
        takes_harm(*listener.family, listener.remembers, false);
    }
}

} // namespace sinew::cli
