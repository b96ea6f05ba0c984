#pragma once
#include "sinew/wire/fake_messages.hpp"
#include "sinew/wire/values.hpp"

#include <vector>

/// Frames of the fake messages, written down by hand, with what they say: for the codec by type and the one by name.
namespace sinew::wire::fake {

struct Number {
    std::string_view field;
    std::int64_t raw = 0;
};

struct Vector {
    const MessageInfo* message;
    Direction direction;
    int id;
    std::vector<Number> numbers;
    std::vector<std::uint8_t> bytes;
    std::uint32_t can_id = 0;
    Options options{};

    Frame frame() const
    {
        Frame made = Frame::of(bytes);
        made.can_id = can_id;
        return made;
    }
    Values values() const;
};

/// A field by its name, in a variant as well.
inline const Field* field_named(const Side& side, std::string_view name)
{
    for (const Variant& variant : side.variants)
        for (const Field& field : variant.fields)
            if (field.name == name)
                return &field;
    for (const Field& field : side.fields)
        if (field.name == name)
            return &field;
    return nullptr;
}

inline Values Vector::values() const
{
    Values out;
    for (const Number& number : numbers)
        out.add(*field_named(message->side(direction), number.field), number.raw);
    return out;
}

inline const Vector whole{&info_of<Whole>,
                          Direction::request,
                          3,
                          {{"byte", 200},
                           {"signed_byte", -2},
                           {"low_first", 0x1234},
                           {"signed_low_first", -100},
                           {"high_first", 0xABCD},
                           {"degrees", -3},
                           {"six", 0x010203040506}},
                          {0xA5, 0x5A, 0x03, 0x14, 0xA9, 0x11, 0xC8, 0xFE, 0x34, 0x12, 0x9C, 0xFF,
                           0xAB, 0xCD, 0xFD, 0xFF, 0xFF, 0xFF, 0x06, 0x05, 0x04, 0x03, 0x02, 0x01}};
inline const Vector packed{&info_of<Whole>,
                           Direction::reply,
                           3,
                           {{"low_first", 0xFEDCBA98},
                            {"seven", -2},
                            {"mode", 2},
                            {"is_hot", 1},
                            {"septets", 0x3FF},
                            {"signed_septets", -129}},
                           {0xA5, 0x5A, 0x03, 0x12, 0xDD, 0x91, 0x98, 0xBA, 0xDC, 0xFE, 0xFE,
                            0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x50, 0x07, 0x7F, 0x81, 0x01}};
inline const Vector far{
    &info_of<Far>, Direction::request, 0, {{"value", 0x44}}, {0xA5, 0x5A, 0x00, 0x05, 0x2D, 0x12, 0x44, 0x44, 0x33}};
inline const Vector two_steps{&info_of<Steps>,
                              Direction::request,
                              31,
                              {{"count", 2}, {"steps", 1}, {"steps", 2}, {"steps", 254}, {"steps", 0}},
                              {0xFF, 0xBF, 0x21, 0x02, 0x0F, 0x01, 0x02, 0xFE, 0x00, 0x6E}};
inline const Vector no_steps{
    &info_of<Steps>, Direction::request, 31, {{"count", 0}}, {0xFF, 0xBF, 0x21, 0x00, 0x0F, 0x11}};
inline const Vector count{&info_of<Steps>, Direction::reply, -1, {{"count", 2}}, {0x02, 0x02}};
inline const Vector look{&info_of<Look>, Direction::request, 4, {}, {0xFF, 0xA4, 0x22, 0x06}};
inline const Vector seen{&info_of<Look>, Direction::reply, -1, {{"state", 9}, {"position", 0x7FF}}, {0x9F, 0x7F}};
inline const Vector parameter{&info_of<Parameter>,
                              Direction::request,
                              2,
                              {{"which", 1}, {"value", -2}},
                              {0xC0, 0x01, 0x00, 0x00, 0xFE, 0xFF, 0xFF, 0xFF},
                              0x142};
inline const Vector parameter_reply{&info_of<Parameter>,
                                    Direction::reply,
                                    2,
                                    {{"which", 1}, {"value", 5}},
                                    {0xC0, 0x01, 0x00, 0x00, 0x05, 0x00, 0x00, 0x00},
                                    0x502,
                                    {.can_reply_base = 0x500}};
inline const Vector parameter_halves{&info_of<Parameter>,
                                     Direction::request,
                                     32,
                                     {{"which", 7}, {"left", 50}, {"right", 200}},
                                     {0xC0, 0x07, 0x00, 0x00, 0x32, 0xC8, 0x00, 0x00},
                                     0x160};
inline const Vector edges{
    &info_of<Edges>, Direction::request, 1, {{"low", 10}, {"high", 90}}, {0x76, 0x0A, 0x5A}, 0x141};
inline const Vector edges_crossed{&info_of<Edges>,
                                  Direction::request,
                                  1,
                                  {{"high", 90}, {"low", 10}},
                                  {0x76, 0x5A, 0x0A},
                                  0x141,
                                  {.bits = high_comes_first, .can_reply_base = 0x500}};
inline const Vector edges_reply{&info_of<Edges>, Direction::reply, 1, {}, {0x76}, 0x141};
inline const Vector edges_other_reply{&info_of<Edges>, Direction::reply, 1, {}, {0x00}, 0x141, {.bits = other_answer}};
inline const Vector everybody_asked{&info_of<Everybody>, Direction::request, -1, {{"value", 9}}, {0x77, 0x09}, 0x280};
inline const Vector everybody_reply{&info_of<Everybody>, Direction::reply, 5, {{"count", 3}}, {0x77, 0x03}, 0x145};

inline const std::vector<const Vector*> all_vectors{&whole,
                                                    &packed,
                                                    &far,
                                                    &two_steps,
                                                    &no_steps,
                                                    &count,
                                                    &look,
                                                    &seen,
                                                    &parameter,
                                                    &parameter_reply,
                                                    &parameter_halves,
                                                    &edges,
                                                    &edges_crossed,
                                                    &edges_reply,
                                                    &edges_other_reply,
                                                    &everybody_asked,
                                                    &everybody_reply};

} // namespace sinew::wire::fake
