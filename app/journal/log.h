#pragma once

#include <cstdint>
#include <string_view>
#include <utility>

#include <fmt/format.h>

/// The log, one line an entry, to the terminal or the journal. This header hides those of the
/// logging library, which are slow to compile.
namespace tribus {

/// Selects the journal or the terminal. Call it once, before the first entry, in a program that
/// serves and therefore goes on when nobody reads its log: SIGPIPE is ignored from then on.
void log_to_journal_or_terminal();

enum class LogLevel : std::uint8_t { info, warning, error };

/// Logs one line. Main thread.
void log_text(LogLevel level, std::string_view text);

template <class... Arguments>
void log_at(LogLevel level, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log_text(level, fmt::format(format, std::forward<Arguments>(arguments)...));
}

template <class... Arguments>
void log_info(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log_text(LogLevel::info, fmt::format(format, std::forward<Arguments>(arguments)...));
}

template <class... Arguments>
void log_warning(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log_text(LogLevel::warning, fmt::format(format, std::forward<Arguments>(arguments)...));
}

template <class... Arguments>
void log_error(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log_text(LogLevel::error, fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace tribus
