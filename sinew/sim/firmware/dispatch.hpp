#pragma once
#include "sinew/sim/firmware/device.hpp"
#include "sinew/wire/codec.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <type_traits>

/// From a frame to what a device does with it, through its rows alone. A device `D` has a member template `serve<M>`,
/// which decodes and calls its overload `handle(const M&)`: a message without one does not compile.
namespace sinew::sim {

template <class D>
struct Service {
    const wire::MessageInfo* message;
    std::optional<Answer> (D::*serve)(const wire::Frame& frame, TimePoint at);
};

template <class D, std::size_t N>
struct Services {
    std::array<Service<D>, N> all{};
    std::array<std::uint8_t, 256> first{}; ///< where to begin to look, by the low byte of the opcode
};

/// One service for each message that has a request.
template <class D, class... M>
constexpr auto services(wire::MessageList<M...>)
{
    constexpr std::size_t count = (std::size_t{wire::info_of<M>.request.exists()} + ... + 0);
    static_assert(count < 256);
    Services<D, count> out;
    std::size_t n = 0;
    const auto add = [&]<class One>(const One*) {
        if constexpr (wire::info_of<One>.request.exists())
            out.all[n++] = {&wire::info_of<One>, &D::template serve<One>};
    };
    (add(static_cast<const M*>(nullptr)), ...);
    for (std::size_t place = count; place-- > 0;)
        out.first[static_cast<std::uint8_t>(out.all[place].message->info.opcode)] = static_cast<std::uint8_t>(place);
    return out;
}

/// Lets the device serve a frame that is `message`. No answer when it has no service for it.
template <class D, std::size_t N>
std::optional<Answer> serve(D& device, const Services<D, N>& services, const wire::MessageInfo* message,
                            const wire::Frame& frame, TimePoint at)
{
    for (std::size_t i = services.first[static_cast<std::uint8_t>(message->info.opcode)]; i < N; ++i)
        if (services.all[i].message == message)
            return (device.*services.all[i].serve)(frame, at);
    return {};
}

/// What `handle` returns for a message: its reply, or nothing when the device ignores it.
template <class M>
using Handled = std::optional<wire::ReplyOf<M>>;

} // namespace sinew::sim
