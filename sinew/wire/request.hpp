#pragma once
#include "sinew/base/time.hpp"
#include "sinew/wire/codec.hpp"

#include <array>
#include <cassert>
#include <span>

namespace sinew::wire {

/// A request ready for the wire, with all that a bus must know to carry it out.
struct Request {
    int id = -1;                          ///< whom it is for
    const MessageInfo* message = nullptr; ///< what it is
    Frame frame{};
    Options options{};        ///< of the device's firmware line
    bool answered = true;     ///< false: no reply is due, it is done when its bits are out
    Duration response_time{}; ///< how long the device may take before it starts to answer
    std::uint8_t replies = 0; ///< how many devices will answer; 0: one, or four where the message is for several
};

namespace detail {

/// All of a request but what its message says.
template <class M>
constexpr Request blank_request(int id, Options options, Duration response_time)
{
    constexpr Range ids = id_range<M, Direction::request>();
    const bool to_all = row<M>.info.broadcast && !info_of<M>.request.layout->can_fixed && id == ids.high;
    return {.id = id,
            .message = &info_of<M>,
            .frame = blank<M, Direction::request>,
            .options = options,
            .answered = info_of<M>.reply.exists() && !to_all,
            .response_time = response_time};
}

} // namespace detail

/// A request from a typed message. Answered unless the message has no reply or goes to every device at once.
template <class M>
std::expected<Request, Error> make_request(int id, const M& message, Options options = {}, Duration response_time = {})
{
    constexpr auto asks = Direction::request;
    std::expected<Request, Error> out{std::in_place, detail::blank_request<M>(id, options, response_time)};
    if (!detail::encode<M, asks>(out->frame, id, message, options, detail::parts<M, asks>)) [[unlikely]]
        return std::unexpected(detail::explain_encoding<M, asks>(id, message, options, detail::parts<M, asks>));
    return out;
}

/// A few requests in a row, without heap.
class Requests
{
public:
    static constexpr std::size_t capacity = 8;

    void add(const Request& request)
    {
        assert(size_ < capacity);
        all_[size_++] = request;
    }
    std::span<const Request> all() const { return std::span(all_).first(size_); }
    bool empty() const { return size_ == 0; }
    void clear() { size_ = 0; }

private:
    std::array<Request, capacity> all_{};
    std::size_t size_ = 0;
};

} // namespace sinew::wire
