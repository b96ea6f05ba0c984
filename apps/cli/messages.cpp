#include "apps/cli/device.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/present.hpp"
#include "apps/cli/reference.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

std::string list_text(const Family& family, const wire::Profile& line)
{
    Table table({"MESSAGE", "OPCODE", "ACCESS", "SAYS"});
    for (const auto* message : line.messages) {
        const auto& info = message->info;
        table.add({std::string(info.name), info.opcode >= 0 ? fmt::format("0x{:02X}", info.opcode) : "",
                   fmt::format("{}{}", to_word(info.access), info.moves ? ", moves" : ""), std::string(info.says)});
    }
    const auto last = fmt::format("{} messages of {} ({}: {}). One of them in full: sinew messages {} NAME",
                                  line.messages.size(), family.title, line.name, line.says, family.name);
    return table.text() + wrap(last, 0, columns()) + '\n';
}

Outcome run(const Words& words)
{
    const auto family = family_named(*words.text("FAMILY"));
    if (!family)
        return std::unexpected(family.error());
    const auto line = profile_named(**family, words.text("--profile").value_or(""));
    if (!line)
        return std::unexpected(line.error());
    std::vector<const wire::MessageInfo*> messages((*line)->messages.begin(), (*line)->messages.end());
    if (const auto name = words.text("NAME")) {
        const auto one = message_named(**family, **line, *name);
        if (!one)
            return std::unexpected(one.error());
        messages = {*one};
    }
    if (words.json()) {
        Json out = Json::array();
        for (const auto* message : messages)
            out.add(to_json(**family, **line, *message));
        print(out);
    } else if (words.has("NAME")) {
        fmt::print("{}", reference_text(**family, **line, *messages.front()));
    } else {
        fmt::print("{}", list_text(**family, **line));
    }
    return exit_done;
}

} // namespace

Verb messages_verb()
{
    return {.name = "messages",
            .says = "The reference: every message of a family, or one of them in full.",
            .arguments = {{"FAMILY", "sam, nuri or rmd"}, {"NAME", "one message", false}},
            .options = {profile_option, {"--json", "", "print a list with one object per message"}},
            .examples = {{"sinew messages sam", "all messages of SAM"},
                         {"sinew messages rmd speed-closed-loop", "every field of one"},
                         {"sinew messages nuri --profile mc --json", "another firmware line, for programs"}},
            .run = run};
}

} // namespace sinew::cli
