#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/recording.h"

/// The log of candump (`candump -L`, `candump -l`; docs/protocols/can.md, "candump logs"): one CAN
/// frame a line.
namespace tribus {

/// Reads the lines of one log in their order, as they come. Thread-bound.
class CandumpReader {
  public:
    explicit CandumpReader(std::string_view file_name) : file_(file_name) {}

    /// Takes the next line, without its end. The kernel stamps a frame when it is sent or taken
    /// from the controller, and hands it over later: frames of two senders may change places, by a
    /// few milliseconds on a busy machine. Such a step back, of 100 ms at most, counts as none: the
    /// frame has the time of the one ahead. Nothing for a blank line, a comment and an error
    /// frame. The error is `file:line:column: text`; the line is left out then, and reading may go
    /// on.
    tl::expected<std::optional<RecordedCanFrame>, std::string> next(std::string_view line);

    /// What the log calls its zero: the time of its first line, or, as the flight recorder writes
    /// it, of a comment `# zero (1436509052.249713)` above.
    Duration log_start() const { return log_start_.value_or(Duration::zero()); }
    std::uint64_t error_frames() const { return error_frames_; }

  private:
    std::string file_;
    unsigned line_ = 0;
    std::optional<Duration> log_start_;
    Duration latest_{};
    std::uint64_t error_frames_ = 0;
};

tl::expected<Recording, std::string> parse_candump(std::string_view content,
                                                   std::string_view file_name);

/// The interfaces that a log names, in the order in which they first appear.
std::vector<std::string> interfaces_in(const Recording& recording);

}  // namespace tribus
