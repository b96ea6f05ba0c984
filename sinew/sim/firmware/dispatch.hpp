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

/// One service for each message that has a request.
template <class D, class... M>
constexpr auto services(wire::MessageList<M...>)
{
    constexpr std::size_t count = (std::size_t{wire::info_of<M>.request.exists()} + ... + 0);
    std::array<Service<D>, count> all{};
    std::size_t n = 0;
    const auto add = [&]<class One>(const One*) {
        if constexpr (wire::info_of<One>.request.exists())
            all[n++] = {&wire::info_of<One>, &D::template serve<One>};
    };
    (add(static_cast<const M*>(nullptr)), ...);
    return all;
}

/// Lets the device serve a frame that is `message`. No answer when it has no service for it.
template <class D, std::size_t N>
std::optional<Answer> serve(D& device, const std::array<Service<D>, N>& all, const wire::MessageInfo* message,
                            const wire::Frame& frame, TimePoint at)
{
    for (const auto& service : all)
        if (service.message == message)
            return (device.*service.serve)(frame, at);
    return {};
}

/// What `handle` returns for a message: its reply, or nothing when the device ignores it.
template <class M>
using Handled = std::optional<wire::ReplyOf<M>>;

} // namespace sinew::sim
