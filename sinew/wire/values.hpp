#pragma once
#include "sinew/base/error.hpp"
#include "sinew/wire/row.hpp"

#include <array>
#include <cassert>
#include <expected>
#include <optional>
#include <span>
#include <string_view>

/// Messages by name and number, for everything that does not know their C++ types. The same rows and the same bits as
/// the typed codec.
namespace sinew::wire {

/// One field and its raw value. A sequence appears as one entry per byte, all with the field of the sequence.
struct Value {
    const Field* field = nullptr;
    std::int64_t raw = 0;
};

/// The values of one message in the order of its row; a regular value without heap.
class Values
{
public:
    static constexpr std::size_t capacity = 24;

    void add(const Field& field, std::int64_t raw)
    {
        assert(size_ < capacity);
        all_[size_++] = {&field, raw};
    }
    std::span<const Value> all() const { return std::span(all_).first(size_); }
    std::optional<std::int64_t> find(std::string_view name) const;
    auto begin() const { return all().begin(); }
    auto end() const { return all().end(); }

private:
    std::array<Value, capacity> all_{};
    std::size_t size_ = 0;
};

struct AddressedValues {
    int id = -1;
    Values values;
};

/// The fields that carry meaning under `options`, with the variant that `selector` chooses (if the side has variants
/// and the selector is known) in place of the field it replaces.
Values value_fields(const Side& side, Options options, std::optional<std::int64_t> selector = {});

/// Fills a frame. Every field of `value_fields` must be among `values` (by name), else `missing_field`.
std::expected<Frame, Error> encode(const MessageInfo& message, Direction direction, int id, const Values& values,
                                   Options options = {});

std::expected<AddressedValues, Error> decode(const MessageInfo& message, Direction direction, const Frame& frame,
                                             Options options = {});

/// The ids that a request of this message can address.
Range request_ids(const MessageInfo& message);

} // namespace sinew::wire
