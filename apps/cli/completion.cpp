#include "apps/cli/candidates.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/verb.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

// Each asks the command itself, which knows its verbs, the joints of the robot file and the messages of a device. What
// it has no candidates for are files.

constexpr std::string_view bash = R"(_sinew() {
    local IFS=$'\n'
    COMPREPLY=($(sinew completion words -- "${COMP_WORDS[@]:0:COMP_CWORD+1}" 2>/dev/null))
    [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]] && compopt -o nospace
}
complete -o default -F _sinew sinew
)";

// In a folder of fpath the whole text is the function, and its first call is already one of those that complete.
constexpr std::string_view zsh = R"(#compdef sinew
_sinew() {
    local -a found end
    found=("${(@f)$(sinew completion words -- "${(@)words[1,CURRENT]}" 2>/dev/null)}")
    [[ $#found == 1 && $found[1] == *= ]] && end=(-S '')
    if [[ -n "${found[1]}" ]]; then
        compadd "${end[@]}" -- "${found[@]}"
    else
        _files
    fi
}
if [[ $funcstack[1] == _sinew ]]; then
    _sinew "$@"
else
    compdef _sinew sinew
fi
)";

constexpr std::string_view fish = R"(function __sinew_words
    set -l line (commandline -opc) (commandline -ct)
    set -l found (sinew completion words -- $line 2>/dev/null)
    if set -q found[1]
        string join \n -- $found
    else
        __fish_complete_path (commandline -ct)
    end
end
complete -c sinew -f -a '(__sinew_words)'
)";

Outcome run(const Words& words)
{
    const auto shell = *words.text("SHELL");
    if (shell == "words") {
        for (const auto& word : candidates(words.all("WORD")))
            fmt::print("{}\n", word);
        return exit_done;
    }
    for (const auto& [name, script] : {std::pair{"bash", bash}, std::pair{"zsh", zsh}, std::pair{"fish", fish}})
        if (shell == name) {
            fmt::print("{}", script);
            return exit_done;
        }
    return fail(Errc::unknown_name,
                fmt::format("there is no completion for '{}'; there is one for bash, zsh and fish", shell));
}

} // namespace

Verb completion_verb()
{
    return {
        .name = "completion",
        .says = "Print what makes a shell complete the words of this command.",
        .arguments = {{"SHELL", "bash, zsh or fish"},
                      {"WORD", "after the shell `words`: a command line, whose last word is completed", false, true}},
        .examples = {{"sinew completion bash", "for bash: source <(sinew completion bash)"},
                     {"sinew completion zsh", "into a file _sinew of a folder in fpath"},
                     {"sinew completion fish", "into ~/.config/fish/completions/sinew.fish"},
                     {"sinew completion words -- sinew get elbow in", "what the shells ask"}},
        .run = run,
        .more = "Verbs, options, families, models, joints, buses, poses and sequences of the robot file (--robot or "
                "SINEW_ROBOT), and "
                "the messages of the device that is named."};
}

} // namespace sinew::cli
