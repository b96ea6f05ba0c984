#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What the command knows of the screen it writes to.
namespace sinew::cli {

bool stdout_is_terminal();
bool stderr_is_terminal();
bool stdin_is_terminal();

/// What has come from stdin: nothing yet, a line, or its end, which is no Enter.
enum class Typed { nothing, enter, end };
Typed typed();
/// Waits for it; a signal ends it as the end of the input does.
Typed wait_for_line();

/// Columns to fill: those of the terminal, else of COLUMNS, else 80; never less than 20.
std::size_t columns();

/// The text in bold, if stdout is a terminal that may have it (NO_COLOR, TERM=dumb).
std::string bold(std::string_view text);

/// Columns that a UTF-8 text takes.
std::size_t width(std::string_view text);

/// The text broken at blanks so that it fits, every line but the first indented. Words that are too long stay whole.
std::string wrap(std::string_view text, std::size_t indent, std::size_t fits);

/// A line of progress on stderr, over the one before; nothing when stderr is no terminal.
void progress(std::string_view text);
void end_progress();

/// Rows with aligned columns, the last of them wrapped. Where the screen is too narrow for that the cells of a row
/// follow each other.
class Table
{
public:
    explicit Table(std::vector<std::string> head) : rows_{std::move(head)} {}
    void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
    bool empty() const { return rows_.size() == 1; }
    /// Lines with a newline each, `indent` blanks before them; columns in which every row is empty are left out.
    std::string text(std::size_t indent = 0) const;

private:
    std::vector<std::size_t> shown_columns() const;
    std::string stacked(std::size_t indent, std::span<const std::size_t> shown) const;

    std::vector<std::vector<std::string>> rows_;
};

} // namespace sinew::cli
