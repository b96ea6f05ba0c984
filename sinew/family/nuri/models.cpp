#include "sinew/family/nuri/models.hpp"

#include "sinew/family/lookup.hpp"
#include "sinew/family/nuri/lines.hpp"

namespace sinew::nuri {
namespace {

constexpr Model products[] = {
    {.name = "RSA", .line = "rsa", .says = "actuator of the document", .source = "nuri.txt; it names no product (N30)"},
    {.name = "MC",
     .line = "mc",
     .says = "motor controller; modes 9 to 16 mean other things",
     .source = "field notes 3: LibNurirobotV00/ProtocolMode.cs"}};

/// Series with the same messages (field notes 3).
constexpr Alias aliases[] = {{"SA", "RSA"}, {"SB", "RSA"}, {"SC", "RSA"}, {"BCA", "MC"}, {"DCA", "MC"}};

} // namespace

std::span<const Model> models()
{
    return products;
}

const Model* find_model(std::string_view name)
{
    return find_by_name(models(), aliases, name);
}

std::span<const Profile> profiles()
{
    static constexpr Profile lines[] = {
        {.line = {.name = "rsa",
                  .says = "the document; also series SA, SB and SC",
                  .source = "nuri.txt",
                  .messages = manual_messages}},
        {.line = {.name = "mc",
                  .says = "series MC, BCA and DCA: 0x0A to 0x10 are other commands than in the document",
                  .source = "field notes 3: LibNurirobotV00/ProtocolMode.cs, NurirobotMC.cs",
                  .messages = mc::messages}}};
    return lines;
}

} // namespace sinew::nuri
