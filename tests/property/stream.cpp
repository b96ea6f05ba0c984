#include "tests/property/stream.hpp"

#include <stdexcept>

namespace sinew::property {

using namespace wire;

Scan Listener::find(std::span<const std::uint8_t> bytes, bool silent) const
{
    return hears == Direction::request ? family->protocol->find_request(bytes, silent)
                                       : family->protocol->find_reply(bytes, awaited, silent);
}

const char* Listener::name() const
{
    return family->name == "sam" ? "SAM device" : hears == Direction::request ? "Nuri device" : "Nuri host";
}

std::vector<Listener> listeners()
{
    return {{&test::family("sam"), Direction::request},
            {&test::family("nuri"), Direction::request},
            {&test::family("nuri"), Direction::reply}};
}

void Receiver::scan(bool silent)
{
    for (;;) {
        const Scan scan = listener_.find(waiting_, silent);
        if (scan.skip + scan.size > waiting_.size())
            throw std::runtime_error("a frame that reaches beyond the bytes");
        if (silent && scan.size == 0 && scan.skip != waiting_.size())
            throw std::runtime_error("silence did not end the wait for a frame");
        const auto begin = waiting_.begin() + static_cast<std::ptrdiff_t>(scan.skip);
        const auto end = begin + static_cast<std::ptrdiff_t>(scan.size);
        if (scan.size != 0)
            found_.push_back({dropped_ + scan.skip, {begin, end}});
        waiting_.erase(waiting_.begin(), end);
        dropped_ += scan.skip + scan.size;
        if (scan.size == 0)
            return;
    }
}

void Receiver::hear(std::span<const std::uint8_t> bytes)
{
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    scan(false);
}

void Receiver::fall_silent()
{
    scan(true);
}

std::vector<std::uint8_t> any_frame(const Listener& listener, test::Random& random)
{
    for (;;) {
        const auto messages = listener.family->manual.messages;
        const auto& message = *messages[random.below(messages.size())];
        if (!message.side(listener.hears).exists())
            continue;
        const Sample x = sample(message, listener.hears, random);
        const auto frame = encode(message, listener.hears, x.id, x.values, x.options);
        return {frame->bytes().begin(), frame->bytes().end()};
    }
}

std::vector<std::uint8_t> garbage(const Listener& listener, test::Random& random)
{
    std::vector<std::uint8_t> out(random.below(24));
    for (auto& byte : out)
        byte = random.one_in(4) ? static_cast<std::uint8_t>(0xFF - random.below(2)) : random.byte();
    if (random.one_in(3)) {
        const auto whole = any_frame(listener, random);
        out.insert(out.end(), whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(random.below(whole.size())));
    }
    return out;
}

} // namespace sinew::property
