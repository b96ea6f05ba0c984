#pragma once
#include "sinew/wire/profile.hpp"
#include "sinew/wire/request.hpp"
#include "sinew/wire/values.hpp"

#include <initializer_list>
#include <string_view>

namespace sinew::wire {

struct NamedNumber {
    std::string_view field;
    std::int64_t raw = 0;
};

/// A request for a message of a firmware line by its name: for whoever serves lines whose rows differ. `not_in_profile`
/// where the line does not list it, `missing_field` where a field of the row is not given; further names are ignored.
std::expected<Request, Error> make_request(const Profile& line, std::string_view message, int id,
                                           std::initializer_list<NamedNumber> numbers, Options options,
                                           Duration response_time);

} // namespace sinew::wire
