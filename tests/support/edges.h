#pragma once

#include <cstdint>
#include <vector>

#include "tests/support/streams.h"

/// Records of edges by the layout of docs/protocols/ppm.md, "Records".
namespace tribus::test {

enum class Edge : std::uint8_t { seen = 0xE0, after_loss = 0xE1, quiet = 0xE2 };

/// A record with a distance in eighths of a microsecond.
inline Bytes edge_record(Edge kind, std::uint32_t eighths) {
    Bytes bytes{static_cast<std::uint8_t>(kind), static_cast<std::uint8_t>(eighths & 0xFF),
                static_cast<std::uint8_t>(eighths / 0x100 & 0xFF),
                static_cast<std::uint8_t>(eighths / 0x10000 & 0xFF)};
    bytes.push_back(static_cast<std::uint8_t>(bytes[0] ^ bytes[1] ^ bytes[2] ^ bytes[3]));
    return bytes;
}

/// The edges of one frame: the first one after a pause, then one for each channel.
inline Bytes ppm_edges(const std::vector<double>& channels_us, double gap_us = 8000) {
    Bytes bytes = edge_record(Edge::seen, static_cast<std::uint32_t>(gap_us * 8));
    for (const double channel : channels_us) {
        append(bytes, edge_record(Edge::seen, static_cast<std::uint32_t>(channel * 8)));
    }
    return bytes;
}

/// The line is quiet for 2.7 ms.
inline Bytes quiet_record() {
    return edge_record(Edge::quiet, 2700 * 8);
}

/// A frame, and the pause that ends it.
inline Bytes ppm_frame(const std::vector<double>& channels_us, double gap_us = 8000) {
    Bytes bytes = ppm_edges(channels_us, gap_us);
    append(bytes, quiet_record());
    return bytes;
}

}  // namespace tribus::test
