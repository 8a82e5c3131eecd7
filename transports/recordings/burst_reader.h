#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/recordings/pieces.h"
#include "transports/recordings/recording.h"
#include "transports/recordings/text.h"

namespace tribus {

/// Reads a recording of bytes burst by burst. Thread-bound.
class BurstReader {
  public:
    using Next = tl::expected<std::optional<Burst>, std::string>;

    /// Any kind but a candump log. `content` must outlive it, and stand at its start.
    BurstReader(Pieces& content, std::string_view file_name, RecordingKind kind);

    /// The next burst, nothing at the end. The one burst of raw bytes comes in pieces. The error is
    /// `file:line:column: text`; nothing can be read after it.
    Next next();
    RecordingKind kind() const { return kind_; }
    /// The line in which the latest burst begins; 0 for raw bytes.
    unsigned line() const { return line_; }
    /// Why the rest was not read, as `file:line:column: text`, once `next` gave nothing: the last
    /// line is cut, or NUL bytes follow.
    const std::optional<std::string>& rest() const { return rest_; }

  private:
    Next next_raw();
    Next next_hex();
    Next next_timed();
    Next next_saleae();
    Next next_of_kind();
    bool next_line(recording_text::Line& line);
    /// Takes an end of the lines, or a mistake in a last line that is cut, for the end of the file.
    Next judged(Next read);
    /// The burst that the lines so far have begun. Nothing if none is begun.
    Next pending_burst();

    Pieces& content_;
    std::string file_;
    RecordingKind kind_;
    /// Not of raw bytes.
    std::optional<recording_text::Lines> lines_;
    /// Time of the burst or row before.
    std::optional<Duration> previous_;
    /// Saleae: the burst that the next rows may continue.
    Burst begun_;
    unsigned begun_line_ = 0;
    bool heading_seen_ = false;
    /// The latest line, whose text may be gone.
    recording_text::Line latest_;
    /// Whether there was a burst or a row.
    bool any_ = false;
    unsigned line_ = 0;
    std::optional<std::string> rest_;
};

}  // namespace tribus
