#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/can_frame.h"
#include "core/time.h"

namespace tribus {

/// Bytes that stood on a wire one behind the other.
struct Burst {
    /// Start of the first byte, from the zero of the recording; absent where no times were kept.
    std::optional<Duration> start;
    std::vector<std::uint8_t> bytes;
    /// For each of `bytes`: it came with a parity or framing error, and its value means nothing.
    std::vector<bool> damaged;
};

/// A frame on a CAN bus, as the machine that recorded it saw it.
struct RecordedCanFrame {
    Duration at{};          ///< when it had arrived, from the zero of the recording
    std::string interface;  ///< that it came or went by: "can0"
    CanFrame frame;
};

enum class RecordingKind : std::uint8_t {
    raw,      ///< the bytes themselves: one burst
    hex,      ///< `20 40 dc! 05`, one burst a line, '#' starts a comment, '!' marks damage
    timed,    ///< `1146 20 40 dc 05`: microseconds of the start, then as hex
    saleae,   ///< CSV of an analyser's serial decoder; bytes that lie close together are one burst
    candump,  ///< `(1436509052.249713) can0 123#1122`: CAN frames, as `candump -L` logs them
};

/// Recorded bytes or CAN frames, in the order of the wire. `timed`: every burst has a start, and
/// none is before the one ahead of it.
struct Recording {
    RecordingKind kind = RecordingKind::raw;
    bool timed = false;
    std::vector<Burst> bursts;
    /// Of a candump log only; none is before the one ahead of it.
    std::vector<RecordedCanFrame> can_frames;
    /// What the log calls the zero of the recording, the time of its first line or the one that a
    /// comment names: since 1970, mostly.
    Duration log_start{};
    /// Notes of the controller in the log, which are no frames of the bus and are left out.
    std::uint64_t error_frames = 0;
};

/// Whether the first bytes of some input can only be raw bytes: one in 16 or more is none of text.
bool looks_raw(std::string_view beginning);

/// The kind that the content shows:
/// - raw, if `looks_raw`; a file with fewer such bytes is refused, because it may be damaged text;
/// - saleae, if the first line starts with `Time [s]`;
/// - candump, if the first line starts with `(`;
/// - timed, if a comment above the data starts with `t_us`, or if every line starts with a decimal
///   number, each greater than the one before and not all of two digits;
/// - hex otherwise, and for an empty file.
/// Thus a file whose lines all start with two digits (`20 40 ...`) is hex unless `# t_us` says
/// otherwise. The error is `file:line:column: text`.
tl::expected<RecordingKind, std::string> tell_recording_kind(std::string_view content,
                                                             std::string_view file_name);

/// Reads a recording of a known kind, or of the kind that its content shows. Reports the first
/// mistake as `file:line:column: text`. An empty file is a recording without bursts. Pure.
tl::expected<Recording, std::string> parse_recording(std::string_view content,
                                                     std::string_view file_name,
                                                     RecordingKind kind);
tl::expected<Recording, std::string> parse_recording(std::string_view content,
                                                     std::string_view file_name);

}  // namespace tribus
