#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/recordings/pieces.h"

namespace tribus {

/// Consecutive bytes on a line.
struct Burst {
    /// Start of the first byte, relative to the zero of the recording; absent without times.
    std::optional<Duration> start;
    std::vector<std::uint8_t> bytes;
    /// One flag for each of `bytes`: the byte had a parity or framing error, and its value is
    /// meaningless.
    std::vector<bool> damaged;
};

/// A frame on a CAN bus, as seen by the recording machine.
struct RecordedCanFrame {
    Duration at{};          ///< arrival, relative to the zero of the recording
    std::string interface;  ///< interface that carried it: "can0"
    CanFrame frame;
};

/// File formats of recordings.
enum class RecordingKind : std::uint8_t {
    raw,      ///< the bytes themselves, as one burst
    hex,      ///< `20 40 dc! 05`, one burst per line, or `2040dc05`, or `0x20 0x40`; '#' starts a
              ///< comment, '!' marks a damaged byte
    timed,    ///< `1146 20 40 dc 05`: start in microseconds, then as hex
    saleae,   ///< CSV of an analyser's serial decoder; bytes close together are one burst
    candump,  ///< `(1436509052.249713) can0 123#1122`: CAN frames, as in a log of `candump -L`, or
              ///< as on its screen
};

/// The kinds' names, in the order of RecordingKind.
inline constexpr std::array<std::string_view, 5> kRecordingKindNames{"raw", "hex", "timed",
                                                                     "saleae", "candump"};

/// Facts of a log of CAN frames besides its frames.
struct LogFacts {
    /// Time of the log's zero, usually since 1970: that of its first line, or of a comment.
    Duration start{};
    /// Number of error frames. They are left out, since they are not frames of the bus.
    std::uint64_t error_frames = 0;
};

/// Recorded bytes or CAN frames in the order of the line. `timed`: every burst has a start, and
/// none is before that of the burst before it.
struct Recording {
    RecordingKind kind = RecordingKind::raw;
    bool timed = false;
    std::vector<Burst> bursts;
    /// Only of a candump log, in the order of time.
    std::vector<RecordedCanFrame> can_frames;
    LogFacts log{};
    /// Why the rest of the file was not read, as `file:line:column: text`.
    std::optional<std::string> rest;
};

/// Whether the first bytes of an input can only be raw bytes: at least one in 16 does not occur in
/// text.
bool looks_raw(std::string_view beginning);

/// The kind that the content shows:
/// - raw, if `looks_raw`, where NUL bytes behind the lines of a text do not count; a file with
/// fewer such bytes is refused, because it may be damaged text;
/// - saleae, if the first line starts with `Time [s]`;
/// - candump, if the first line starts with `(`, or is one of candump's screen;
/// - timed, if a comment above the data starts with `t_us`, or if every line starts with a decimal
///   number, each greater than the one before and not all of two digits;
/// - hex otherwise, and for an empty file.
/// Thus a file whose lines all start with two digits (`20 40 ...`) is hex unless it has `# t_us`.
/// The error is `file:line:column: text`. Pure and reentrant.
tl::expected<RecordingKind, std::string> detect_recording_kind(std::string_view content,
                                                               std::string_view file_name);
/// The same for `content` from its start, where it stands again afterwards.
tl::expected<RecordingKind, std::string> detect_recording_kind(Pieces& content,
                                                               std::string_view file_name);

/// Reads a recording of a known kind, or of the kind that its content shows. Returns the first
/// error as `file:line:column: text`; a mistake in a last line without a line end, and NUL bytes
/// behind the text, are not errors but end it (`Recording::rest`). An empty file is a recording
/// without bursts. Pure and reentrant.
tl::expected<Recording, std::string> parse_recording(std::string_view content,
                                                     std::string_view file_name,
                                                     RecordingKind kind);
tl::expected<Recording, std::string> parse_recording(std::string_view content,
                                                     std::string_view file_name);

}  // namespace tribus
