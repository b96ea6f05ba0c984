#include "apps/cli/command_line.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/help.hpp"
#include "apps/cli/verb.hpp"
#include "sinew/base/bytes.hpp"

#include <CLI/CLI.hpp>
#include <csignal>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <system_error>

namespace sinew::cli {
namespace {

/// What CLI11 has read of one verb.
struct Parsed {
    std::map<std::string_view, std::vector<std::string>> texts;
    std::map<std::string_view, bool> switches;
};

std::unexpected<Error> refuse_word(const Verb& verb, const std::string& word)
{
    if (!word.starts_with('-'))
        return fail(Errc::bad_argument, fmt::format("'{}' is one word too many; write {}", word, usage(verb)));
    std::vector<std::string_view> names{"--help"};
    for (const auto& option : verb.options)
        names.push_back(option.name);
    return fail(Errc::bad_argument, fmt::format("{} has no option {}{}", verb.name, word, did_you_mean(word, names)));
}

/// A negative number is a value and not an option; the blank hides that from CLI11 and is taken off again.
std::string hide_negative(std::string_view word)
{
    const bool negative = word.size() > 1 && word[0] == '-' && (word[1] == '.' || (word[1] >= '0' && word[1] <= '9'));
    return fmt::format("{}{}", negative ? " " : "", word);
}

std::string unhide(const std::string& word)
{
    return word.starts_with(" -") ? word.substr(1) : word;
}

std::expected<Words, Error> understand(const Verb& verb, std::span<char* const> given)
{
    CLI::App app;
    app.set_help_flag();
    app.allow_extras();
    Parsed parsed;
    std::vector<std::string> positional;
    app.add_option("words", positional);
    for (const auto& option : verb.options) {
        if (option.value.empty())
            app.add_flag(std::string(option.name), parsed.switches[option.name])
                ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
        else
            app.add_option(std::string(option.name), parsed.texts[option.name])->allow_extra_args(false);
    }
    std::vector<std::string> words;
    for (std::size_t i = given.size(); i-- > 0;) // CLI11 takes them from the back
        words.push_back(hide_negative(given[i]));
    try {
        app.parse(words);
    } catch (const CLI::ParseError& error) {
        return fail(Errc::bad_argument, fmt::format("{}; see sinew {} --help", error.what(), verb.name));
    }
    for (const auto& word : app.remaining())
        if (word != "--") // what follows it are no options, and stands among the arguments
            return refuse_word(verb, unhide(word));

    Words out;
    std::size_t next = 0;
    for (const auto& argument : verb.arguments)
        for (std::size_t taken = 0; next < positional.size() && (argument.many || taken == 0); ++taken)
            out.add(argument.name, unhide(positional[next++]));
    if (next < positional.size())
        return refuse_word(verb, unhide(positional[next]));
    for (const auto& [name, values] : parsed.texts)
        for (const auto& value : values)
            out.add(name, unhide(value));
    for (const auto& [name, on] : parsed.switches)
        if (on)
            out.add(name, "");
    out.act = verb.acts && !out.has("--dry-run");
    for (const auto& option : verb.options)
        if (!option.many && out.all(option.name).size() > 1)
            return fail(Errc::bad_argument, fmt::format("{} is given twice", option.name));
    for (const auto& argument : verb.arguments)
        if (argument.required && !out.has(argument.name))
            return fail(Errc::bad_argument, fmt::format("{} is missing; write {}", argument.name, usage(verb)));
    return out;
}

const Verb* find_verb(std::string_view name)
{
    for (const auto& verb : verbs())
        if (verb.name == name)
            return &verb;
    return nullptr;
}

/// A verb and how many words it is made of; two of them before one: "sim look" before "sim".
struct Found {
    const Verb* verb = nullptr;
    std::size_t words = 0;
};

Found find_verb(std::span<char* const> words)
{
    if (words.size() > 1)
        if (const Verb* verb = find_verb(fmt::format("{} {}", words[0], words[1])))
            return {verb, 2};
    return {find_verb(words[0]), 1};
}

int complain(std::string_view sentence, int code)
{
    std::fflush(stdout);
    // Not fmt::print, which throws: where stderr takes nothing either, the code is all that is left to say.
    (void)std::fputs(fmt::format("sinew: {}\n", sentence).c_str(), stderr);
    return code;
}

int unknown_verb(std::string_view word)
{
    std::vector<std::string_view> names, longer;
    for (const auto& verb : verbs()) {
        names.push_back(verb.name);
        if (verb.name.starts_with(fmt::format("{} ", word)))
            longer.push_back(verb.name);
    }
    if (!longer.empty())
        return complain(fmt::format("'{}' needs a second word: {}", word, fmt::join(longer, ", ")), exit_usage);
    return complain(fmt::format("there is no verb '{}'{}{} sinew --help lists them", word, did_you_mean(word, names),
                                nearest(word, names).empty() ? ";" : ""),
                    exit_usage);
}

bool asks_for_help(std::span<char* const> words)
{
    for (const std::string_view word : words) {
        if (word == "--")
            return false;
        if (word == "--help" || word == "-h")
            return true;
    }
    return false;
}

int run_verb(const Verb& verb, std::span<char* const> given)
{
    if (asks_for_help(given)) {
        fmt::print("{}", help(verb));
        return exit_done;
    }
    const auto words = understand(verb, given);
    if (!words)
        return complain(to_sentence(words.error()), exit_code(words.error().code));
    const auto outcome = verb.run(*words);
    if (!outcome)
        return complain(to_sentence(outcome.error()), exit_code(outcome.error().code));
    return *outcome;
}

int run_words(std::span<char* const> words)
{
    if (words.empty()) {
        fmt::print(stderr, "{}", help());
        return exit_usage;
    }
    const std::string_view first = words[0];
    if (first == "--version") {
        fmt::print("sinew {}\n", SINEW_VERSION);
        return exit_done;
    }
    if (first == "help" && words.size() > 1) {
        if (words[1] == std::string_view("--json")) {
            fmt::print("{}", help_json());
            return exit_done;
        }
        for (const auto& topic : help_topics())
            if (topic.name == words[1]) {
                fmt::print("{}", help(topic));
                return exit_done;
            }
        const Verb* verb = find_verb(words.subspan(1)).verb;
        if (verb == nullptr)
            return unknown_verb(words[1]);
        fmt::print("{}", help(*verb));
        return exit_done;
    }
    if (first == "--help" || first == "-h" || first == "help") {
        fmt::print("{}", help());
        return exit_done;
    }
    const Found found = find_verb(words);
    return found.verb != nullptr ? run_verb(*found.verb, words.subspan(found.words)) : unknown_verb(first);
}

} // namespace

int run(int argc, char** argv)
{
    const auto unwritten = [] { return complain("the output could not be written; is the disk full?", exit_internal); };
    // A file that reaches its limit is an error like a full disk, and no death.
    (void)std::signal(SIGXFSZ, SIG_IGN);
    try {
        const int code = run_words(std::span(argv + 1, argc > 0 ? static_cast<std::size_t>(argc - 1) : 0));
        return std::fflush(stdout) == 0 && std::ferror(stdout) == 0 ? code : unwritten();
    } catch (const std::system_error&) { // fmt throws it when stdout takes no more
        return unwritten();
    }
}

} // namespace sinew::cli
