#pragma once

#include <termios.h>

#include <optional>
#include <string_view>

#include "app/screen_parts.h"

/// The terminal that standard output is, for live views.
namespace tribus {

/// By its size now, the locale, and NO_COLOR.
ScreenStyle screen_style();

/// The terminal's other screen, without a cursor, for as long as it lives.
class AlternateScreen {
  public:
    AlternateScreen() { show("\x1b[?1049h\x1b[?25l"); }
    AlternateScreen(const AlternateScreen&) = delete;
    AlternateScreen& operator=(const AlternateScreen&) = delete;
    ~AlternateScreen() { show("\x1b[?25h\x1b[?1049l"); }
    static void show(std::string_view text);
};

/// Standard input gives single keys, unseen, for as long as it lives; nothing changes where it is
/// no terminal.
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
