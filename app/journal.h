#pragma once

#include <memory>

namespace spdlog {
class formatter;
}

namespace tribus {

/// Standard error is the systemd journal, as $JOURNAL_STREAM says (systemd.exec(5)).
bool stderr_is_journal();

/// Lines for it: no time, which it has itself, and the level as it wants it, `<4>` (sd-daemon(3)).
std::unique_ptr<spdlog::formatter> journal_formatter();

}  // namespace tribus
