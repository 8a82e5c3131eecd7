#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <spdlog/common.h>
#include <spdlog/formatter.h>

#include "app/journal/log_fields.h"

/// Format of the log, on a terminal and in the systemd journal.
namespace tribus {

/// Replaces each control character, each character that turns the direction of writing, and each
/// byte that is not UTF-8, such as `\x1b` as four characters. Names come from files, which may be
/// damaged, devices and other nodes of a bus; they must not begin a log line or control the
/// terminal. Pure.
std::string without_control_characters(std::string_view text);

/// `12:00:05.123 info what happened`, for standard error.
std::unique_ptr<spdlog::formatter> terminal_formatter();

/// Writes each message as a line, or loses it if there is no room. Never waits. Thread-bound.
std::shared_ptr<spdlog::sinks::sink> terminal_sink(int descriptor, bool colours);

/// True if standard error is the journal, according to $JOURNAL_STREAM (systemd.exec(5)).
bool stderr_is_journal();

/// An entry in the journal's native protocol (systemd.io/JOURNAL_NATIVE_PROTOCOL): the message, its
/// priority of syslog(3), and the fields that have a name. All bytes are allowed. Pure.
std::string journal_entry(spdlog::level::level_enum level, std::string_view message,
                          std::span<const LogField> fields);

/// Sends each message as an entry, with the current `LogFields`. If the journal does not take it,
/// writes it to standard error, which the journal reads too, with the priority in front
/// (sd-daemon(3)). Never waits. Thread-bound.
std::shared_ptr<spdlog::sinks::sink> journal_sink(
    const std::string& socket = "/run/systemd/journal/socket");

}  // namespace tribus
