#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <spdlog/common.h>
#include <spdlog/formatter.h>

#include "app/log_fields.h"

/// What the log looks like, on a terminal and in the systemd journal.
namespace tribus {

/// Names come from files, devices and other nodes of a bus: no control character of one begins a
/// line of the log, or speaks to the terminal. Each is written as `\x1b`. Pure.
std::string without_control_characters(std::string_view text);

/// `12:00:05.123 info what happened`, for standard error.
std::unique_ptr<spdlog::formatter> terminal_formatter();

/// Standard error is the journal, as $JOURNAL_STREAM says (systemd.exec(5)).
bool stderr_is_journal();

/// An entry in the journal's native protocol (systemd.io/JOURNAL_NATIVE_PROTOCOL): the message, its
/// priority by syslog(3), and those fields that have a name. Any bytes are allowed. Pure.
std::string journal_entry(spdlog::level::level_enum level, std::string_view message,
                          std::span<const LogField> fields);

/// Hands each message over as an entry, with the `LogFields` of the moment. What the journal does
/// not take goes to standard error, which it reads as well, as a line with its priority in front
/// (sd-daemon(3)). Never waits. Thread-bound.
std::shared_ptr<spdlog::sinks::sink> journal_sink(
    const std::string& socket = "/run/systemd/journal/socket");

}  // namespace tribus
