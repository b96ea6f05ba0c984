#include "sinew/diagnosis/audience.hpp"

#include <algorithm>
#include <array>

namespace sinew::diagnosis {
namespace {

constexpr std::size_t bits_per_byte = 10;
constexpr std::size_t longest_frame = wire::Frame::capacity;
/// How far two oscillators are off against each other where a UART is to work at all.
constexpr double clock_errors[] = {-0.03, -0.02, -0.01, 0.0, 0.01, 0.02, 0.03};
/// A fall is seen up to a sixteenth of a bit late, and the middle of a bit is where its oscillator says.
constexpr double sampling_shifts[] = {-0.06, -0.015, 0.015, 0.06};

/// Some receivers drop a byte without its stop bit, some deliver it.
std::vector<std::uint8_t> delivered(std::span<const HeardByte> heard, bool takes_broken)
{
    std::vector<std::uint8_t> out;
    for (const auto& byte : heard)
        if (takes_broken || !byte.broken)
            out.push_back(byte.value);
    return out;
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

std::vector<HeardByte> hear_at(std::span<const std::uint8_t> bytes, double sent_bps, const Ear& ear)
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
    const double bit = sent_bps / ear.bit_rate;
    const double middle = 0.5 + ear.sampling_shift;
    const auto level = [&](double time) {
        return time >= static_cast<double>(count) || levels[static_cast<std::size_t>(time)];
    };
    std::vector<HeardByte> out;
    double ready = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        const bool falls = !levels[i] && (i == 0 || levels[i - 1]);
        const auto fall = static_cast<double>(i);
        if (!falls || fall < ready || level(fall + middle * bit))
            continue;
        unsigned byte = 0;
        for (int n = 0; n < 8; ++n)
            byte |= static_cast<unsigned>(level(fall + (1 + n + middle) * bit)) << n;
        ready = fall + (9 + middle) * bit;
        out.push_back({static_cast<std::uint8_t>(byte), !level(ready)});
    }
    return out;
}

Audience::Audience()
{
    for (const auto* family : families()) {
        if (family->can)
            continue;
        for (const auto& rate : family->bit_rates)
            for (const double error : clock_errors)
                for (const double shift : sampling_shifts)
                    listeners_.push_back({family, {rate.bps * (1.0 + error), shift}});
    }
}

/// Takes the requests off the front of the bytes: whether one of them is more than a read, and how many bytes at the
/// end are still remembered. Most listeners hear the same, so what was worked out is kept.
Audience::Verdict Audience::judge(const Family& family, std::span<const std::uint8_t> bytes, bool silent) const
{
    constexpr std::size_t most_kept = 50'000;
    std::string key(bytes.begin(), bytes.end());
    key += silent ? 's' : 'g';
    key += family.name;
    if (const auto kept = kept_.find(key); kept != kept_.end())
        return kept->second;
    Verdict out;
    std::span<const std::uint8_t> rest = bytes;
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
            out.harm = out.harm || (message != nullptr && message->info.access != wire::Access::read);
        }
    }
    out.remembered = rest.size();
    if (kept_.size() == most_kept)
        kept_.clear();
    kept_.emplace(std::move(key), out);
    return out;
}

bool Audience::harmless(const wire::Frame& frame, std::uint32_t bit_rate) const
{
    if (bit_rate == 0)
        return std::ranges::all_of(all_rates(), [&](std::uint32_t rate) { return harmless(frame, rate); });
    for (const auto& listener : listeners_) {
        const auto heard = hear_at(frame.bytes(), bit_rate, listener.ear);
        for (const bool takes_broken : {false, true}) {
            auto bytes = delivered(heard, takes_broken);
            if (bytes.empty())
                continue;
            if (judge(*listener.family, bytes, true).harm)
                return false;
            const auto& remembers = listener.remembers[takes_broken];
            if (remembers.empty())
                continue;
            bytes.insert(bytes.begin(), remembers.begin(), remembers.end());
            if (judge(*listener.family, bytes, false).harm || judge(*listener.family, bytes, true).harm)
                return false;
        }
    }
    return true;
}

void Audience::hear(const wire::Frame& frame, std::uint32_t bit_rate)
{
    for (auto& listener : listeners_) {
        const auto heard = bit_rate != 0 ? hear_at(frame.bytes(), bit_rate, listener.ear) : std::vector<HeardByte>{};
        for (const bool takes_broken : {false, true}) {
            auto& remembers = listener.remembers[takes_broken];
            if (bit_rate == 0)
                remembers.clear(); // what was heard is not known
            const auto bytes = delivered(heard, takes_broken);
            remembers.insert(remembers.end(), bytes.begin(), bytes.end());
            const auto left = judge(*listener.family, remembers, false).remembered;
            remembers.erase(remembers.begin(), remembers.end() - static_cast<std::ptrdiff_t>(left));
        }
    }
}

} // namespace sinew::diagnosis
