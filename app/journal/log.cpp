#include "app/journal/log.h"

#include <unistd.h>

#include <csignal>
#include <memory>
#include <utility>

#include <spdlog/spdlog.h>

#include "app/journal/journal.h"
#include "app/journal/terminal_stream.h"

namespace tribus {

void log_to_journal_or_terminal() {
    // A log whose reader has gone must not end the program.
    std::signal(SIGPIPE, SIG_IGN);
    auto sink = stderr_is_journal() ? journal_sink()
                                    : terminal_sink(STDERR_FILENO, shows_colour(STDERR_FILENO));
    auto logger = std::make_shared<spdlog::logger>("tribus", std::move(sink));
    logger->set_formatter(terminal_formatter());
    spdlog::set_default_logger(std::move(logger));
}

void log_text(LogLevel level, std::string_view text) {
    const auto library_level = level == LogLevel::info      ? spdlog::level::info
                               : level == LogLevel::warning ? spdlog::level::warn
                                                            : spdlog::level::err;
    // With a single argument spdlog does not format, so braces in the text stay.
    spdlog::default_logger_raw()->log(library_level,
                                      spdlog::string_view_t(text.data(), text.size()));
}

}  // namespace tribus
