#include "sinew/wire/by_name.hpp"

namespace sinew::wire {

std::expected<Request, Error> make_request(const Profile& line, std::string_view message, int id,
                                           std::initializer_list<NamedNumber> numbers, Options options,
                                           Duration response_time)
{
    const MessageInfo* info = line.find(message);
    if (info == nullptr)
        return std::unexpected(Error{.code = Errc::not_in_profile, .message = message, .id = id});
    Values values;
    const auto selector = [&]() -> std::optional<std::int64_t> {
        for (const auto& number : numbers)
            if (number.field == info->request.selector)
                return number.raw;
        return std::nullopt;
    }();
    for (const auto& wanted : value_fields(info->request, options, selector))
        for (const auto& number : numbers)
            if (number.field == wanted.field->name)
                values.add(*wanted.field, number.raw);
    const auto frame = encode(*info, Direction::request, id, values, options);
    if (!frame)
        return std::unexpected(frame.error());
    return Request{id, info, *frame, options, info->reply.exists(), response_time};
}

} // namespace sinew::wire
