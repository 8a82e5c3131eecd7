#pragma once

#include <cstdint>
#include <string_view>
#include <utility>

#include <fmt/format.h>

/// What the program says while it runs: one line each, to the terminal or the journal (`run` says
/// where). Without the logging library's headers, of which each file would compile the same again.
namespace tribus {

/// Once, before anything is logged.
void log_to_journal_or_terminal();

enum class LogLevel : std::uint8_t { info, warning, error };

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
