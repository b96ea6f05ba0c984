#include "sinew/diagnosis/audience.hpp"

#include <algorithm>
#include <array>

namespace sinew::diagnosis {
namespace {

/// How far two oscillators are off against each other where a UART is to work at all.
constexpr double clock_errors[] = {-0.03, -0.02, -0.01, 0.0, 0.01, 0.02, 0.03};
/// A fall is seen up to a sixteenth of a bit late, and the middle of a bit is where its oscillator says.
constexpr double sampling_shifts[] = {-0.06, -0.015, 0.015, 0.06};

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

LineLevels::LineLevels(std::span<const std::uint8_t> bytes)
{
    bool before = true;
    const auto add = [&](bool level) {
        if (before && !level)
            falls[static_cast<std::size_t>(fall_count++)] = count;
        high[static_cast<std::size_t>(count++)] = level;
        before = level;
    };
    for (const auto byte : bytes) {
        add(false);
        for (int bit = 0; bit < 8; ++bit)
            add((byte >> bit & 1) != 0);
        add(true);
    }
}

void hear_at(const LineLevels& line, double sent_bps, const Ear& ear, std::vector<HeardByte>& out)
{
    // Time counts in bits as they were sent; a byte is sampled so long after its fall.
    const double bit = sent_bps / ear.bit_rate;
    std::array<double, LineLevels::bits_per_byte> samples{};
    for (std::size_t n = 0; n < samples.size(); ++n)
        samples[n] = (static_cast<double>(n) + 0.5 + ear.sampling_shift) * bit;
    const auto level = [&](int fall, std::size_t sample) {
        const auto time = static_cast<int>(fall + samples[sample]);
        return time >= line.count || line.high[static_cast<std::size_t>(time)];
    };
    out.clear();
    double ready = 0.0;
    for (const int fall : std::span(line.falls).first(static_cast<std::size_t>(line.fall_count))) {
        if (fall < ready || level(fall, 0))
            continue;
        unsigned byte = 0;
        for (unsigned n = 0; n < 8; ++n)
            byte |= static_cast<unsigned>(level(fall, 1 + n)) << n;
        ready = fall + samples.back();
        out.push_back({static_cast<std::uint8_t>(byte), !level(fall, samples.size() - 1)});
    }
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

void Audience::listen(const wire::Frame& frame, std::uint32_t bit_rate) const
{
    const auto is_same = [](const wire::Frame& a, const wire::Frame& b) {
        return std::ranges::equal(a.bytes(), b.bytes());
    };
    if (listened_ && listened_->second == bit_rate && is_same(listened_->first, frame))
        return;
    const LineLevels line(frame.bytes());
    std::vector<HeardByte> heard;
    for (auto& listener : listeners_) {
        hear_at(line, bit_rate, listener.ear, heard);
        for (auto& bytes : listener.hears)
            bytes.clear();
        for (const auto& byte : heard) {
            if (!byte.broken)
                listener.hears[0].push_back(byte.value);
            listener.hears[1].push_back(byte.value);
        }
    }
    listened_.emplace(frame, bit_rate);
}

/// Takes the requests off the front of the bytes: whether one of them is more than a read, and how many bytes at the
/// end are still remembered.
Audience::Verdict Audience::judge(const Family& family, std::span<const std::uint8_t> bytes, bool silent) const
{
    constexpr std::size_t most_kept = 50'000;
    key_.assign(bytes.begin(), bytes.end());
    key_ += silent ? 's' : 'g';
    key_ += family.name;
    if (const auto kept = kept_.find(key_); kept != kept_.end())
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
    kept_.emplace(key_, out);
    return out;
}

bool Audience::harmless(const wire::Frame& frame, std::uint32_t bit_rate) const
{
    if (bit_rate == 0)
        return std::ranges::all_of(all_rates(), [&](std::uint32_t rate) { return harmless(frame, rate); });
    listen(frame, bit_rate);
    Bytes after;
    for (const auto& listener : listeners_) {
        for (std::size_t way = 0; way < listener.hears.size(); ++way) {
            const auto& hears = listener.hears[way];
            if (hears.empty())
                continue;
            if (judge(*listener.family, hears, true).harm)
                return false;
            const auto& remembers = listener.remembers[way];
            if (remembers.empty())
                continue;
            after = remembers;
            after.insert(after.end(), hears.begin(), hears.end());
            if (judge(*listener.family, after, false).harm || judge(*listener.family, after, true).harm)
                return false;
        }
    }
    return true;
}

void Audience::hear(const wire::Frame& frame, std::uint32_t bit_rate)
{
    if (bit_rate != 0)
        listen(frame, bit_rate);
    for (auto& listener : listeners_) {
        for (std::size_t way = 0; way < listener.hears.size(); ++way) {
            auto& remembers = listener.remembers[way];
            if (bit_rate == 0) {
                remembers.clear(); // what was heard is not known
                continue;
            }
            remembers.insert(remembers.end(), listener.hears[way].begin(), listener.hears[way].end());
            const auto left = judge(*listener.family, remembers, false).remembered;
            remembers.erase(remembers.begin(), remembers.end() - static_cast<std::ptrdiff_t>(left));
        }
    }
}

} // namespace sinew::diagnosis
