#include "transports/codecs/crsf/frames.h"

#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/crsf/wire.h"

namespace tribus {

using namespace crsf_wire;

std::span<const std::uint8_t> CrsfFrames::payload_of(std::span<const std::uint8_t> frame) {
    return frame.subspan(kPayloadAt, frame.size() - kPayloadAt - 1);
}

std::size_t CrsfFrames::needed_bytes(std::span<const std::uint8_t> bytes) const {
    if (!is_address(bytes[0])) {
        return 0;
    }
    if (bytes.size() <= kTypeAt) {
        return kTypeAt + 1;
    }
    const std::size_t length = bytes[kLengthAt];
    const std::size_t least = kTypeAndCheck + least_payload(bytes[kTypeAt]);
    return length >= least && length <= kMostLength ? kUncounted + length : 0;
}

bool CrsfFrames::check_holds(std::span<const std::uint8_t> frame) const {
    const std::size_t last = frame.size() - 1;
    return Crc8D5::of(0, frame.subspan(kTypeAt, last - kTypeAt)) == frame[last];
}

}  // namespace tribus
