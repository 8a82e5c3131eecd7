#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <spdlog/common.h>

#include "app/log_fields.h"

/// The systemd journal.
namespace tribus {

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
