#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/recordings/pieces.h"
#include "transports/recordings/recording.h"
#include "transports/recordings/text.h"
#include "transports/recordings/time_steps.h"

/// Logs of candump (`candump -L`, `candump -l`; docs/protocols/can.md, "candump logs"), and what it
/// shows on a screen: one CAN frame per line.
namespace tribus {

/// Whether each line must have a time, which candump shows on a screen only if it is asked to.
enum class LogTimes : std::uint8_t { needed, optional };

/// Reads the lines of one log in order, as they arrive. Thread-bound.
class CandumpReader {
  public:
    explicit CandumpReader(std::string_view file_name, LogTimes times = LogTimes::needed)
        : file_(file_name), times_(times) {}

    /// Takes the next line, without its line end. The kernel stamps a frame when it is sent or
    /// taken from the controller, and delivers it later, so frames of two senders may change
    /// places, by a few milliseconds on a busy machine. A step back of at most 100 ms is therefore
    /// corrected: the frame gets the time of the one before, as does a frame without a time.
    /// Returns nothing for a blank line, a
    /// comment and an error frame. The error is `file:line:column: text`; that line is skipped, and
    /// reading may continue.
    tl::expected<std::optional<RecordedCanFrame>, std::string> next(std::string_view line);

    /// What is wrong with the log as a whole, once all lines are taken.
    tl::expected<void, std::string> finish() const;
    /// The facts so far. The comment above the first line that sets the log's zero is
    /// `# zero (1436509052.249713)`, as the flight recorder writes it.
    LogFacts facts() const {
        return {.start = log_start_.value_or(Duration::zero()), .error_frames = error_frames_};
    }

  private:
    tl::expected<Duration, std::string> time_of(std::string_view line, std::string_view first);

    std::string file_;
    LogTimes times_;
    unsigned line_ = 0;
    std::optional<Duration> log_start_;
    Duration latest_{};
    DifferenceWatch differences_;
    std::uint64_t error_frames_ = 0;
};

tl::expected<Recording, std::string> parse_candump(std::string_view content,
                                                   std::string_view file_name);

/// Reads the frames of one log in order, however long it is. Thread-bound.
class CandumpFrames {
  public:
    /// `content` must outlive it, and stand at its start.
    CandumpFrames(Pieces& content, std::string_view file_name, LogTimes times = LogTimes::needed)
        : lines_(content), file_(file_name), reader_(file_name, times) {}

    /// The next frame, nothing at the end. Errors as above.
    tl::expected<std::optional<RecordedCanFrame>, std::string> next();
    LogFacts facts() const { return reader_.facts(); }
    /// The line of the latest frame.
    unsigned line() const { return line_; }
    /// Why the rest was not read, as `file:line:column: text`, once `next` gave nothing: the last
    /// line is cut, or NUL bytes follow.
    const std::optional<std::string>& rest() const { return rest_; }

  private:
    recording_text::Lines lines_;
    std::string file_;
    CandumpReader reader_;
    bool any_ = false;
    unsigned line_ = 0;
    std::optional<std::string> rest_;
};

}  // namespace tribus
