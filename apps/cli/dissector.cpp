#include "apps/cli/device.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/formats.hpp"
#include "apps/cli/new_file.hpp"
#include "sinew/base/bytes.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

std::expected<std::string, Error> text_for(const Words& words)
{
    const auto format = *words.text("FORMAT");
    constexpr std::string_view formats[] = {"lua", "dbc"};
    if (format == "lua") {
        if (words.has("--profile"))
            return fail(Errc::bad_argument, "--profile goes with dbc; the dissector reads by the manuals");
        return lua_dissector();
    }
    if (format != "dbc")
        return fail(Errc::bad_argument,
                    fmt::format("FORMAT is lua or dbc, not '{}'{}", format, did_you_mean(format, formats)));
    const auto family = family_named("rmd");
    const auto line =
        family ? profile_named(**family, words.text("--profile").value_or("")) : std::unexpected(family.error());
    if (!line)
        return std::unexpected(line.error());
    return dbc_file(**family, **line);
}

Outcome run(const Words& words)
{
    const auto text = text_for(words);
    if (!text)
        return std::unexpected(text.error());
    const auto path = words.text("--out");
    if (!path) {
        fmt::print("{}", *text);
        return exit_done;
    }
    auto file = NewFile::make(*path);
    if (!file)
        return std::unexpected(file.error());
    if (auto written = file->write(*text); !written)
        return std::unexpected(written.error());
    if (auto kept = file->keep(); !kept)
        return std::unexpected(kept.error());
    return exit_done;
}

} // namespace

Verb dissector_verb()
{
    return {.name = "dissector",
            .says = "Print the messages for other programs: a dissector for Wireshark, or a DBC file.",
            .arguments = {{"FORMAT", "lua (Wireshark and tshark, all families) or dbc (RMD)"}},
            .options = {{"--out", "FILE", "where to; stdout where it is not given"},
                        {"--profile", "P", "dbc: the firmware line; the manual's where it is not given"}},
            .examples = {{"sinew dissector lua --out sinew.lua", "then tshark -X lua_script:sinew.lua -r run.pcapng"},
                         {"sinew dissector dbc --out rmd.dbc", "for CAN tools"}},
            .run = run,
            .more = "A DBC file cannot tell requests from replies where both have one identifier: its signals are then "
                    "those of the replies."};
}

} // namespace sinew::cli
