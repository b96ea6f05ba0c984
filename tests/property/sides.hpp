#pragma once
#include "sinew/base/bytes.hpp"
#include "sinew/wire/values.hpp"
#include "tests/support/families.hpp"
#include "tests/support/random.hpp"

#include <string>
#include <vector>

/// Random messages of any row, and what to do to them.
namespace sinew::property {

/// One direction of one message.
struct NamedSide {
    const test::Family* family = nullptr;
    const wire::MessageInfo* message = nullptr;
    wire::Direction direction{};
};

std::vector<NamedSide> all_sides();

/// "sam_set_id_request".
std::string test_name(const NamedSide& side);

/// A message to a device, all values in range.
struct Sample {
    int id = -1;
    wire::Values values;
    wire::Options options{};
};

/// Draws options, id, parameter and values. Sequences are as long as the field before them says.
Sample sample(const wire::MessageInfo& message, wire::Direction direction, test::Random& random);

/// The ids that one direction can carry; not given: it carries none.
wire::Range ids_of(const wire::MessageInfo& message, wire::Direction direction);

bool same_values(const wire::Values& a, const wire::Values& b);

/// The values with the one at `at` replaced, or left out.
wire::Values with(const wire::Values& values, std::size_t at, std::int64_t raw);
wire::Values without(const wire::Values& values, std::size_t at);

/// Places of the values whose coding carries more than is allowed.
std::vector<std::size_t> narrow_values(const wire::Values& values);

/// The frame with one field overwritten, its repeats and its checksum made to fit.
wire::Frame with_raw(const wire::MessageInfo& message, wire::Direction direction, wire::Frame frame,
                     const wire::Field& field, std::int64_t raw);

/// Makes the checksum fit, if the message has one.
void seal(const wire::Side& side, wire::Frame& frame);

/// Whether an error says which field of which message was out of which range.
bool names(const Error& error, const wire::MessageInfo& message, const wire::Field& field, std::int64_t value);

} // namespace sinew::property
