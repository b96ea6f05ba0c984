#pragma once
#include "sinew/record/captured.hpp"

#include <string_view>

/// The log of candump (`candump -L`, `-l`), which canplayer, python-can and SavvyCAN read:
///
///     (1436509052.249713) can0 141#9A00000000000000 T
///
/// Time in seconds, bus, frame, and where it is known R for received and T for sent by the host. A 29-bit identifier
/// has eight digits, a remote request `#R` and its length, an error frame the flag 0x20000000 in its identifier.
/// Written are microseconds; up to nanoseconds are read. CAN only, and what was discarded is not told. CAN FD is
/// refused. Source: can-utils, candump.c and lib.h.
namespace sinew::record {

/// A frame as can-utils write it: `141#9A00000000000000`, dots between bytes allowed. `bad_hex` says what is wrong.
std::expected<Captured, Error> parse_can(std::string_view word);
/// The same the other way round.
std::string can_text(const Captured& captured);

/// Empty lines and lines that begin with # or ; are passed over. A last line without its end is an error, for its frame
/// may be cut short.
class CandumpReader final : public Reader
{
public:
    static constexpr std::size_t longest_line = 512;

    void feed(std::span<const std::uint8_t> bytes) override;
    void end() override { ended_ = true; }
    std::expected<std::optional<Captured>, Error> next() override;

private:
    std::optional<std::string_view> next_line();

    std::string text_;
    std::size_t at_ = 0;
    std::size_t line_ = 0;
    bool ended_ = false;
    bool skipping_ = false; // the rest of a line that was too long
};

class CandumpWriter final : public Writer
{
public:
    std::expected<void, Error> add(const Captured& captured, std::string& out) override;
};

} // namespace sinew::record
