#include "sinew/bus/agree.hpp"

#include <algorithm>

namespace sinew::bus {

bool agree(const wire::Side& side, const wire::Frame& first, const wire::Frame& second)
{
    constexpr std::int64_t share = 32;
    constexpr std::int64_t few = 4;
    if (first.size != second.size)
        return false;
    for (const wire::Field& f : side.fields) {
        if (f.kind == wire::Kind::checksum || f.kind == wire::Kind::sequence)
            continue;
        std::int64_t a = 0;
        std::int64_t b = 0;
        if (!wire::get(f, first.data.data(), a) || !wire::get(f, second.data.data(), b))
            return false;
        const wire::Range range = wire::allowed(f);
        const std::int64_t span = range.high - range.low + 1;
        const bool may_move = f.kind == wire::Kind::value || f.kind == wire::Kind::repeat;
        const std::int64_t most = may_move && span > few ? std::max<std::int64_t>(1, span / share) : 0;
        if (std::max(a, b) - std::min(a, b) > most)
            return false;
    }
    return true;
}

} // namespace sinew::bus
