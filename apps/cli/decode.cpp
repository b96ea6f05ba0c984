#include "apps/cli/decoder.hpp"
#include "apps/cli/exit_codes.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/config/text_file.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <iterator>

namespace sinew::cli {
namespace {

std::expected<std::string, Error> read_file(const std::string& path)
{
    auto text = config::read_text(path, "bytes in hex");
    if (!text)
        return text;
    if (text->contains('\0'))
        return fail(Errc::bad_file,
                    fmt::format("{} is no text; sinew sniff --replay reads recordings (.mcap, .pcapng)", path));
    if (lines_of(*text).empty())
        return fail(Errc::bad_file, fmt::format("{} has no bytes in hex", path));
    return text;
}

std::expected<std::string, Error> read_text(const Words& words)
{
    const auto given = words.all("TEXT");
    if (given.empty() && stdin_is_terminal())
        return fail(Errc::bad_argument, "nothing to decode: give bytes in hex, candump lines, a file or - for stdin");
    if (given.empty() || (given.size() == 1 && given[0] == "-"))
        return std::string(std::istreambuf_iterator<char>(std::cin), {});
    std::error_code none;
    if (given.size() == 1 && std::filesystem::is_directory(given[0], none))
        return fail(Errc::bad_file, fmt::format("{} is a folder", given[0]));
    if (given.size() == 1 && std::filesystem::is_regular_file(given[0], none))
        return read_file(given[0]);
    if (given.size() == 1 && given[0].find_first_of("./") != std::string::npos &&
        given[0].find('#') == std::string::npos)
        return fail(Errc::bad_file, fmt::format("there is no file {}", given[0]));
    std::string text;
    for (const auto& word : given)
        text += word + ' ';
    return text;
}

std::expected<DecodeOptions, Error> options_from(const Words& words)
{
    DecodeOptions out{.profile = words.text("--profile").value_or(""),
                      .model = words.text("--model").value_or(""),
                      .reply_to = words.text("--reply-to").value_or("")};
    if (const auto name = words.text("--family")) {
        const auto family = family_named(*name);
        if (!family)
            return std::unexpected(family.error());
        out.family = *family;
    } else if (!out.reply_to.empty()) {
        // Only SAM's answers cannot be told without.
        out.family = find_family("sam");
    }
    if (words.has("--requests") && words.has("--replies"))
        return fail(Errc::bad_argument, "--requests and --replies exclude each other");
    if (words.has("--requests"))
        out.only = wire::Direction::request;
    if (words.has("--replies"))
        out.only = wire::Direction::reply;
    return out;
}

Json to_json(const Decoded& one)
{
    Json out = Json::object({{"family", one.family->name}, {"bytes", to_hex(one.bytes)}});
    if (one.family->can)
        out.set("can_id", one.frame.can_id);
    Json readings = Json::array();
    for (const auto& r : one.readings)
        readings.add(Json::object({{"direction", r.direction == wire::Direction::request ? "request" : "reply"},
                                   {"message", r.message->name()},
                                   {"id", r.id >= 0 ? Json(r.id) : Json()},
                                   {"values", to_json(r.values)}}));
    out.set("readings", std::move(readings));
    if (one.error)
        out.set("error", Json::object({{"code", to_word(one.error->code)}, {"sentence", to_sentence(*one.error)}}));
    return out;
}

void print_text(const Decoded& one)
{
    fmt::print("{}\n", bold(one.family->can ? to_text(one.frame, true) : to_hex(one.bytes)));
    if (one.error)
        fmt::print("  {}: {}\n", one.family->name, wrap(to_sentence(*one.error), 4, columns()));
    bool unscaled = false;
    for (const auto& reading : one.readings) {
        const bool alone = one.readings.size() == 1;
        const std::string_view either = reading.direction == wire::Direction::request ? "as request: " : "as reply: ";
        fmt::print("  {}{} {}\n", alone ? "" : either, one.family->name,
                   describe(*reading.message, reading.direction, reading.id));
        const auto table = table_of(reading.values);
        if (!table.empty())
            fmt::print("{}", table.text(4));
        for (const auto& value : reading.message->side(reading.direction).fields)
            unscaled =
                unscaled || (!value.unit.empty() && value.scale == wire::by_model && value.kind == wire::Kind::value);
        for (const auto& value : reading.values)
            unscaled = unscaled && !value.value;
    }
    if (unscaled)
        fmt::print(stderr, "note: the scale depends on the model; --model gives it\n");
}

/// Prints what a line means, or adds it to `out`.
Outcome decode_line(const Words& words, std::string_view line, const DecodeOptions& options, Json& out)
{
    const auto captured = parse_capture(line);
    if (!captured)
        return std::unexpected(captured.error());
    const auto decoded = decode(*captured, options);
    if (!decoded)
        return std::unexpected(decoded.error());
    int code = exit_done;
    for (const auto& one : *decoded) {
        code = one.error ? exit_bad_answer : code;
        if (words.json())
            out.add(to_json(one));
        else
            print_text(one);
    }
    return code;
}

Outcome run(const Words& words)
{
    const auto options = options_from(words);
    if (!options)
        return std::unexpected(options.error());
    const auto text = read_text(words);
    if (!text)
        return std::unexpected(text.error());
    const auto lines = lines_of(*text);
    if (lines.empty())
        return fail(Errc::bad_hex, "no bytes given; write them in hex, such as FF E0 C2 01 00 00 23");
    if (lines.size() == 1) {
        Json out = Json::array();
        const auto outcome = decode_line(words, lines.front().text, *options, out);
        if (outcome && words.json())
            print(out);
        return outcome;
    }
    int code = exit_done;
    Json out = Json::array();
    for (const auto& line : lines) {
        const auto outcome = decode_line(words, line.text, *options, out);
        // One bad line of a log does not end the log.
        if (!outcome)
            fmt::print(stderr, "sinew: line {}: {}\n", line.number, to_sentence(outcome.error()));
        code = std::max(code, outcome ? *outcome : exit_code(outcome.error().code));
    }
    if (words.json())
        print(out);
    return code;
}

} // namespace

Verb decode_verb()
{
    return {
        .name = "decode",
        .says = "Say what bytes mean: names, values and units.",
        .arguments = {{"TEXT", "bytes in hex, candump lines, a file with either, or - for stdin", false, true}},
        .options = {{"--family", "F", "sam, nuri or rmd; guessed where it is not given"},
                    {"--profile", "P", "the firmware line; the manual's where it is not given"},
                    {"--model", "M", "the model, for scales that depend on it"},
                    {"--reply-to", "MESSAGE", "the bytes answer this message; answers of SAM cannot be told otherwise"},
                    {"--requests", "", "read requests only"},
                    {"--replies", "", "read answers only"},
                    {"--json", "", "print a list with one object per frame"}},
        .examples = {{"sinew decode FF E0 C2 01 00 00 23", "a frame of SAM"},
                     {"sinew decode \"can0 141 [8] A2 00 00 00 28 23 00 00\"", "a line of candump"},
                     {"sinew decode 0B 33 --reply-to read-input-voltage --model SAM-20", "an answer of SAM"},
                     {"candump -L can0 | sinew decode -", "a log"}},
        .run = run,
        .more = "A frame of RMD can be a request and an answer; then both readings are shown.",
        .ends = {exit_bad_answer, exit_refused}};
}

} // namespace sinew::cli
