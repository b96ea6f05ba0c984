#include "sinew/link/slcan_adapter.hpp"

#include <utility>

namespace sinew::link {
namespace {

bool are_hex(std::string_view digits, std::size_t count)
{
    return digits.size() == count && std::ranges::all_of(digits, [](char c) {
               return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'F') || (c >= 'a' && c <= 'f');
           });
}

} // namespace

std::optional<wire::Frame> SlcanAdapter::obey(std::string_view line)
{
    if (line.empty())
        return answer("\r");
    const bool is_closed = mode_ == Mode::closed;
    const std::string_view rest = line.substr(1);
    switch (line.front()) {
    case 'S':
        return answer_if(is_closed && set_bit_rate(rest));
    case 's':
        if (!is_closed || !(are_hex(rest, 4) || are_hex(rest, 6)))
            return refuse();
        has_rate_ = true;
        bit_rate_ = 0;
        return answer("\r");
    case 'O':
    case 'L':
        if (!is_closed || !has_rate_ || !rest.empty())
            return refuse();
        mode_ = line.front() == 'O' ? Mode::open : Mode::listening;
        return answer("\r");
    case 'C':
        if (is_closed || !rest.empty())
            return refuse();
        mode_ = Mode::closed;
        return answer("\r");
    case 't':
    case 'T':
    case 'r':
    case 'R':
        return transmit(line);
    case 'V':
        return rest.empty() ? answer("V1013\r") : refuse();
    case 'v':
        return rest.empty() ? answer("v1013\r") : refuse();
    case 'N':
        return rest.empty() ? answer("NSNEW\r") : refuse();
    case 'F':
        return !is_closed && rest.empty() ? tell_flags() : refuse();
    case 'Z':
        return answer_if(is_closed && rest == "0");
    case 'X':
        return answer_if(is_closed && (rest == "0" || rest == "1"));
    case 'M':
    case 'm':
        return answer_if(is_closed && are_hex(rest, 8));
    default:
        return refuse();
    }
}

std::optional<wire::Frame> SlcanAdapter::transmit(std::string_view line)
{
    const slcan::Line decoded = slcan::decode(line);
    const bool is_frame = decoded.kind == slcan::Kind::frame || decoded.kind == slcan::Kind::foreign;
    if (mode_ != Mode::open || !is_frame)
        return refuse();
    if (decoded.kind == slcan::Kind::frame)
        return decoded.frame; // acknowledged once the bus has taken it
    const bool is_extended = line.front() == 'T' || line.front() == 'R';
    return answer(is_extended ? "Z\r" : "z\r");
}

void SlcanAdapter::acknowledge(bool is_taken)
{
    if (!is_taken)
        note(slcan::flag::transmit_queue_full);
    answer(is_taken ? "z\r" : "\a");
}

std::optional<wire::Frame> SlcanAdapter::tell_flags()
{
    constexpr std::string_view digits = "0123456789ABCDEF";
    const std::uint8_t flags = std::exchange(flags_, std::uint8_t{0});
    const char text[] = {'F', digits[flags >> 4u], digits[flags & 0xFu], slcan::end_of_line};
    return answer({text, sizeof text});
}

std::optional<wire::Frame> SlcanAdapter::refuse()
{
    return answer("\a");
}

std::optional<wire::Frame> SlcanAdapter::answer(std::string_view text)
{
    put({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    return std::nullopt;
}

bool SlcanAdapter::set_bit_rate(std::string_view code)
{
    if (code.size() != 1 || code[0] < '0' || code[0] > '8')
        return false;
    bit_rate_ = slcan::bit_rates[static_cast<std::size_t>(code[0] - '0')];
    has_rate_ = true;
    return true;
}

bool SlcanAdapter::offer(const wire::Frame& frame)
{
    std::array<std::uint8_t, slcan::longest_frame_text> text;
    const std::size_t size = slcan::encode(frame, text);
    if (!is_open() || size == 0)
        return false;
    const bool fits = put(std::span(text).first(size));
    if (!fits)
        note(slcan::flag::receive_queue_full);
    return fits;
}

bool SlcanAdapter::put(std::span<const std::uint8_t> bytes)
{
    if (bytes.size() > pending_.size() - size_)
        return false;
    std::ranges::copy(bytes, pending_.begin() + size_);
    size_ += bytes.size();
    return true;
}

void SlcanAdapter::drop(std::size_t count)
{
    count = std::min(count, size_);
    std::copy(pending_.begin() + count, pending_.begin() + size_, pending_.begin());
    size_ -= count;
}

} // namespace sinew::link
