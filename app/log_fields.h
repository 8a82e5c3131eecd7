#pragma once

#include <array>
#include <string_view>

namespace tribus {

/// What a log entry is about, for programs that read the journal: `TRIBUS_INPUT`, "receiver".
struct LogField {
    std::string_view name{};
    std::string_view text{};
};

/// As long as it lives, all that this thread logs is about that. What it is given must outlive it.
/// One at a time, so that each entry is about one thing.
class LogFields {
  public:
    static constexpr std::size_t kMost = 2;

    explicit LogFields(LogField first, LogField second = {});
    LogFields(const LogFields&) = delete;
    LogFields& operator=(const LogFields&) = delete;
    ~LogFields();

    /// Of this thread; those without a name count for nothing.
    static const std::array<LogField, kMost>& current();
};

}  // namespace tribus
