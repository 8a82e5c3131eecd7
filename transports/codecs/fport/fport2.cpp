#include <algorithm>

#include "transports/codecs/fport/fport.h"

namespace tribus {
namespace {

constexpr std::size_t kFport2TypeAt = 1;
constexpr std::size_t kFport2ContentAt = 2;
/// Bytes of a frame of the receiver beside those that its length counts: length, type, sum.
constexpr std::size_t kUncountedInControl = 3;
/// Of a telemetry frame: length and sum.
constexpr std::size_t kUncountedInTelemetry = 2;

constexpr std::uint8_t kControlType = 0xFF;
constexpr std::uint8_t kUpdateStartType = 0xF0;
constexpr std::uint8_t kUpdateDataType = 0xF1;
constexpr std::uint8_t kUpdateStopType = 0xF2;

constexpr std::uint8_t kFport2TelemetryLength = 0x08;
constexpr std::uint8_t kUpdateDataLength = 0x20;
constexpr std::uint8_t kLength8 = fport_content_bytes(8);
constexpr std::uint8_t kLength16 = fport_content_bytes(16);
constexpr std::uint8_t kLength24 = fport_content_bytes(24);
static_assert(kLength8 == 0x0D && kLength16 == 0x18 && kLength24 == 0x23);

constexpr std::size_t kUsualFport2Frame = kLength16 + kUncountedInControl;

/// Whether a frame of the receiver of this length may have this type.
bool is_control(std::uint8_t length, std::uint8_t type) {
    switch (length) {
        case kLength8:
        case kLength24:
            return type == kControlType;
        case kLength16:
            return type == kControlType || type == kUpdateStartType || type == kUpdateStopType;
        case kUpdateDataLength:
            return type == kUpdateDataType;
        default:
            return false;
    }
}

bool may_begin_fport2(std::uint8_t length) {
    return length == kFport2TelemetryLength || length == kLength16 || length == kLength8 ||
           length == kLength24 || length == kUpdateDataLength;
}

bool usual_sum_holds(std::span<const std::uint8_t> bytes) {
    constexpr std::size_t kSummed = kUsualFport2Frame - kFport2TypeAt;
    return fport_sum_holds(byte_sums::sum_of(bytes.subspan<kFport2TypeAt, kSummed>()));
}

}  // namespace

Fport2Decoder::Taken Fport2Decoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                           DecodedFrame& frame) {
    // The usual case, 16 channels in one read. The general way gives the same.
    if (buffer_.size() == 0 && bytes.size() >= kUsualFport2Frame && bytes[0] == kLength16 &&
        bytes[kFport2TypeAt] == kControlType && usual_sum_holds(bytes)) {
        frame.first_byte = buffer_.first_position();
        frame.length = kUsualFport2Frame;
        frame.channels.received = received;
        channels_.read(bytes.subspan<kFport2ContentAt, kLength16>(), frame.channels);
        buffer_.pass(kUsualFport2Frame);
        return {kUsualFport2Frame, true};
    }
    return FramedDecoder::decode(bytes, received, frame);
}

std::size_t Fport2Decoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    const std::uint8_t length = bytes[0];
    if (!may_begin_fport2(length)) {
        return 0;
    }
    if (length == kFport2TelemetryLength) {
        return kFport2TelemetryLength + kUncountedInTelemetry;
    }
    if (bytes.size() <= kFport2TypeAt) {
        return kFport2TypeAt + 1;
    }
    return is_control(length, bytes[kFport2TypeAt]) ? length + kUncountedInControl : 0;
}

bool Fport2Decoder::check_holds(std::span<const std::uint8_t> frame) const {
    return fport_sum_holds(byte_sums::sum_of(frame.subspan(kFport2TypeAt)));
}

bool Fport2Decoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    if (frame[0] == kFport2TelemetryLength || frame[kFport2TypeAt] != kControlType) {
        return false;
    }
    channels_.read_any(frame.subspan(kFport2ContentAt, frame[0]), channels);
    return true;
}

}  // namespace tribus
