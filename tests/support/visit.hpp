#pragma once
#include "sinew/wire/codec.hpp"

#include <type_traits>

/// Visits the typed messages, so that one test body serves all of them.
namespace sinew::test {

template <class M, wire::Direction D>
inline constexpr bool side_exists =
    D == wire::Direction::request
        ? !std::is_same_v<typename std::remove_cvref_t<decltype(wire::row<M>)>::RequestMessage, wire::Nothing>
        : !std::is_same_v<typename std::remove_cvref_t<decltype(wire::row<M>)>::ReplyMessage, wire::Nothing>;

/// The struct that carries the values of one direction.
template <class M, wire::Direction D>
using ValueOf = std::conditional_t<D == wire::Direction::request, M, wire::ReplyOf<M>>;

template <class M, wire::Direction D>
std::expected<wire::Frame, Error> encode_side(int id, const ValueOf<M, D>& value, wire::Options options)
{
    if constexpr (D == wire::Direction::request)
        return wire::encode_request<M>(id, value, options);
    else
        return wire::encode_reply<M>(id, value, options);
}

template <class M, wire::Direction D>
std::expected<wire::Addressed<ValueOf<M, D>>, Error> decode_side(const wire::Frame& frame, wire::Options options)
{
    if constexpr (D == wire::Direction::request)
        return wire::decode_request<M>(frame, options);
    else
        return wire::decode_reply<M>(frame, options);
}

/// Calls `visit.operator()<M, Direction>()` for every direction that the messages of the list have.
template <class Visit, class... Messages>
void for_each_side(wire::MessageList<Messages...>, Visit&& visit)
{
    const auto both = [&]<class M>() {
        if constexpr (side_exists<M, wire::Direction::request>)
            visit.template operator()<M, wire::Direction::request>();
        if constexpr (side_exists<M, wire::Direction::reply>)
            visit.template operator()<M, wire::Direction::reply>();
    };
    (both.template operator()<Messages>(), ...);
}

} // namespace sinew::test
