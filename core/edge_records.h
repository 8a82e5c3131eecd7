#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// The edges of a line of pulses as bytes: what a link makes of the kernel's time stamps, and what
/// an output hands to a link that makes pulses (docs/protocols/ppm.md, "Records"). Pure and
/// reentrant.
namespace tribus::edge_records {

enum class EdgeKind : std::uint8_t {
    edge = 0xE0,
    /// Edges before this one were not seen; its time says nothing.
    edge_after_loss = 0xE1,
    /// No edge came for the time that is given.
    quiet = 0xE2,
};

struct EdgeRecord {
    EdgeKind kind = EdgeKind::edge;
    /// Time since the edge before, in eighths of a microsecond, at most `kLongestEighths`.
    std::uint32_t eighths = 0;

    bool operator==(const EdgeRecord&) const = default;
};

/// Kind, time with the low byte first, exclusive or of these bytes.
inline constexpr std::size_t kRecordBytes = 5;
inline constexpr std::uint32_t kLongestEighths = 0xFFFFFF;
inline constexpr std::uint32_t kEighthsPerMicrosecond = 8;
/// A pause between two frames is at least so long, and a channel is shorter
/// (docs/protocols/ppm.md).
inline constexpr std::uint32_t kFrameGapEighths = 2700 * kEighthsPerMicrosecond;

inline void put(std::span<std::uint8_t> bytes, EdgeRecord record) {
    const std::uint32_t eighths = std::min(record.eighths, kLongestEighths);
    bytes[0] = static_cast<std::uint8_t>(record.kind);
    bytes[1] = static_cast<std::uint8_t>(eighths);
    bytes[2] = static_cast<std::uint8_t>(eighths >> 8U);
    bytes[3] = static_cast<std::uint8_t>(eighths >> 16U);
    bytes[4] = static_cast<std::uint8_t>(bytes[0] ^ bytes[1] ^ bytes[2] ^ bytes[3]);
}

inline bool begins_record(std::uint8_t byte) {
    return byte >= static_cast<std::uint8_t>(EdgeKind::edge) &&
           byte <= static_cast<std::uint8_t>(EdgeKind::quiet);
}

/// The record of `kRecordBytes` bytes; nothing if they are none.
inline std::optional<EdgeRecord> record_of(std::span<const std::uint8_t> bytes) {
    const int check = bytes[0] ^ bytes[1] ^ bytes[2] ^ bytes[3];
    if (!begins_record(bytes[0]) || check != bytes[4]) {
        return std::nullopt;
    }
    return EdgeRecord{static_cast<EdgeKind>(bytes[0]),
                      bytes[1] | static_cast<std::uint32_t>(bytes[2]) << 8U |
                          static_cast<std::uint32_t>(bytes[3]) << 16U};
}

}  // namespace tribus::edge_records
