#include "transports/codecs/mavlink/messages.h"

#include <algorithm>

namespace tribus {

using namespace mavlink_wire;

namespace {

/// The header, which differs between the versions.
struct MavlinkHeader {
    std::size_t bytes = 0;
    std::uint32_t id = 0;
    std::uint8_t system = 0;
    std::uint8_t component = 0;
};

/// Of a frame that is whole.
MavlinkHeader header_of(std::span<const std::uint8_t> frame) {
    if (frame[0] == kVersion1) {
        return {.bytes = kHeader1Bytes, .id = frame[5], .system = frame[3], .component = frame[4]};
    }
    const std::uint32_t id = frame[7] | static_cast<std::uint32_t>(frame[8]) << 8U |
                             static_cast<std::uint32_t>(frame[9]) << 16U;
    return {.bytes = kHeader2Bytes, .id = id, .system = frame[5], .component = frame[6]};
}

}  // namespace

std::size_t MavlinkMessages::needed_bytes(std::span<const std::uint8_t> bytes) const {
    if (bytes[0] == kVersion1) {
        return bytes.size() < 2 ? 2 : kHeader1Bytes + bytes[1] + kCrcBytes;
    }
    if (bytes[0] != kVersion2) {
        return 0;
    }
    if (bytes.size() < 3) {
        return 3;
    }
    const std::uint8_t flags = bytes[2];
    if ((flags & ~kSignedFlag) != 0) {
        return 0;
    }
    return kHeader2Bytes + bytes[1] + kCrcBytes + (flags == kSignedFlag ? kSignatureBytes : 0);
}

bool MavlinkMessages::check_holds(std::span<const std::uint8_t> frame) const {
    const MavlinkHeader header = header_of(frame);
    const MessageKind* const kind = find_kind(header.id);
    if (kind == nullptr) {
        return true;
    }
    const std::size_t end = header.bytes + frame[1];
    const std::uint16_t sent = field_at<std::uint16_t>(frame, end);
    return crc_of(frame.subspan(1, end - 1), kind->crc_extra) == sent;
}

bool MavlinkMessages::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    const MavlinkHeader header = header_of(frame);
    const MessageKind* const kind = find_kind(header.id);
    const std::size_t length = frame[1];
    if (kind == nullptr || (frame[0] == kVersion1 && length < kind->length_1)) {
        return false;
    }
    MavlinkMessage message{.id = header.id, .system = header.system, .component = header.component};
    std::ranges::copy(frame.subspan(header.bytes, std::min<std::size_t>(length, kind->length)),
                      message.payload.begin());
    return take(message, channels);
}

}  // namespace tribus
