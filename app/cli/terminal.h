#pragma once

#include <termios.h>

#include <optional>
#include <string_view>

#include "app/cli/screen_parts.h"

/// The terminal on standard output, for live views.
namespace tribus {

/// From its present size, the locale, and whether it shows colour.
ScreenStyle screen_style();

/// The terminal's alternate screen without a cursor, while it lives.
class AlternateScreen {
  public:
    AlternateScreen() { show("\x1b[?1049h\x1b[?25l"); }
    AlternateScreen(const AlternateScreen&) = delete;
    AlternateScreen& operator=(const AlternateScreen&) = delete;
    ~AlternateScreen() { show("\x1b[?25h\x1b[?1049l"); }
    /// Writes to the terminal at once.
    static void show(std::string_view text);
};

/// Standard input delivers single keys without echo while it lives. Does nothing if standard input
/// is no terminal.
class KeyMode {
  public:
    KeyMode();
    KeyMode(const KeyMode&) = delete;
    KeyMode& operator=(const KeyMode&) = delete;
    ~KeyMode();

  private:
    std::optional<termios> before_;
};

}  // namespace tribus
