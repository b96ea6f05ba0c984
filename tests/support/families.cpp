#include "tests/support/families.hpp"

#include "sinew/family/nuri/framing.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/family/sam/framing.hpp"
#include "sinew/family/sam/messages.hpp"
#include "tests/support/visit.hpp"

#include <array>
#include <cstdlib>
#include <vector>

namespace sinew::test {
namespace {

template <class List>
std::vector<TypedCodec> typed_codecs()
{
    std::vector<TypedCodec> out;
    for_each_side(List{}, [&]<class M, wire::Direction D>() {
        out.push_back({&wire::info_of<M>, D, [](const wire::Frame& frame, wire::Options options) {
                           auto decoded = decode_side<M, D>(frame, options);
                           if (!decoded)
                               return std::expected<wire::Frame, Error>(std::unexpected(decoded.error()));
                           return encode_side<M, D>(decoded->id, decoded->message, options);
                       }});
    });
    return out;
}

} // namespace

Again Family::again(const wire::MessageInfo& message, wire::Direction direction) const
{
    for (const auto& codec : typed)
        if (codec.message == &message && codec.direction == direction)
            return codec.again;
    std::abort();
}

std::span<const Family> families()
{
    static const auto sam_typed = typed_codecs<sam::ManualMessages>();
    static const auto nuri_typed = typed_codecs<nuri::ManualMessages>();
    static const auto rmd_typed = typed_codecs<rmd::ManualMessages>();
    static const std::array<Family, 3> all{{
        {"sam", {.name = "manual", .messages = sam::manual_messages}, &sam::protocol(), sam_typed},
        {"nuri", {.name = "manual", .messages = nuri::manual_messages}, &nuri::protocol(), nuri_typed},
        {"rmd", {.name = "manual", .messages = rmd::manual_messages}, &rmd::protocol(), rmd_typed},
    }};
    return all;
}

const Family& family(std::string_view name)
{
    for (const auto& one : families())
        if (one.name == name)
            return one;
    std::abort();
}

} // namespace sinew::test
