#pragma once

#include <array>
#include <string_view>

namespace tribus {

/// What a log entry is about, for programs that read the journal, such as `TRIBUS_INPUT`,
/// "receiver".
struct LogField {
    std::string_view name{};
    std::string_view text{};
};

/// While it lives, all log entries of this thread carry these fields. The texts must outlive it. At
/// most one object per thread at a time.
class LogFields {
  public:
    static constexpr std::size_t kMost = 2;

    explicit LogFields(LogField first, LogField second = {});
    LogFields(const LogFields&) = delete;
    LogFields& operator=(const LogFields&) = delete;
    ~LogFields();

    /// The fields of this thread; those without a name are unused.
    static const std::array<LogField, kMost>& current();
};

}  // namespace tribus
