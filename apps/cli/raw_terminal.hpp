#pragma once
#include <optional>
#include <string>
#include <termios.h>

namespace sinew::cli {

/// The terminal at stdin without echo and lines, for as long as this lives: keys come as they are pressed. Ctrl-C stays
/// a signal.
class RawTerminal
{
public:
    RawTerminal();
    ~RawTerminal();
    RawTerminal(const RawTerminal&) = delete;
    RawTerminal& operator=(const RawTerminal&) = delete;

    /// What was pressed since the last call; empty: nothing. Nothing at all: stdin has ended.
    std::optional<std::string> keys();

private:
    termios before_{};
    bool changed_ = false;
};

} // namespace sinew::cli
