#include "transports/codecs/mavlink/messages.h"

#include <algorithm>
#include <array>
#include <string_view>

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

/// The frame must be whole.
MavlinkHeader header_of(std::span<const std::uint8_t> frame) {
    if (frame[0] == kVersion1) {
        return {.bytes = kHeader1Bytes, .id = frame[5], .system = frame[3], .component = frame[4]};
    }
    const std::uint32_t id = frame[7] | static_cast<std::uint32_t>(frame[8]) << 8U |
                             static_cast<std::uint32_t>(frame[9]) << 16U;
    return {.bytes = kHeader2Bytes, .id = id, .system = frame[5], .component = frame[6]};
}

/// The length of a frame, by its first three bytes; 0 if it must not be read.
std::size_t whole_bytes(std::span<const std::uint8_t> bytes) {
    if (bytes[0] == kVersion1) {
        return kHeader1Bytes + bytes[1] + kCrcBytes;
    }
    const std::uint8_t flags = bytes[2];
    if ((flags & ~kSignedFlag) != 0) {
        return 0;
    }
    return kHeader2Bytes + bytes[1] + kCrcBytes + (flags == kSignedFlag ? kSignatureBytes : 0);
}

/// So many bytes of a long message are looked at.
constexpr std::size_t kLongHead = 16;

bool is_long(std::span<const std::uint8_t> bytes) {
    return whole_bytes(bytes) > LineBuffer::kCapacity;
}

/// Behind the first, in the order of SignatureFault. Without a key only the first occurs.
constexpr std::array<std::string_view, 8> kMavlinkCauses{
    "other_sender", "unsigned", "wrong_signature", "replayed", "too_old", "too_many_streams",
    "late",         "ahead"};

std::span<const std::string_view> causes_with(const std::optional<SecretKey>& key) {
    return std::span(kMavlinkCauses).first(key ? kMavlinkCauses.size() : 1);
}

}  // namespace

MavlinkMessages::MavlinkMessages(const std::optional<SecretKey>& key)
    : FramedDecoder(causes_with(key)) {
    static_assert(kMavlinkCauses.size() <= kMostOwnCauses);
    if (key) {
        verifier_.emplace(*key);
    }
}

void MavlinkMessages::use_clock(const WallClock& clock) {
    if (verifier_) {
        verifier_->use_clock(clock);
    }
}

/// Counts the message if it is not.
bool MavlinkMessages::is_genuine(std::span<const std::uint8_t> frame, std::uint32_t id,
                                 Instant received) {
    const auto fault = verifier_->fault_of(frame, received);
    if (!fault || (fault == SignatureFault::no_signature && takes_unsigned(id))) {
        return true;
    }
    refuse(1 + static_cast<std::size_t>(*fault));
    return false;
}

void MavlinkMessages::damaged_byte() {
    passed_over_ = 0;
    FramedDecoder::damaged_byte();
}

bool MavlinkMessages::silence(DecodedFrame& frame) {
    passed_over_ = 0;
    return FramedDecoder::silence(frame);
}

void MavlinkMessages::reset() {
    passed_over_ = 0;
    FramedDecoder::reset();
}

ByteDecoder::Taken MavlinkMessages::decode(std::span<const std::uint8_t> bytes, Instant received,
                                           DecodedFrame& frame) {
    const std::size_t passed = std::min(passed_over_, bytes.size());
    buffer_.pass(passed);
    passed_over_ -= passed;
    if (passed > 0 && passed == bytes.size()) {
        return {.bytes = passed, .frame = false};
    }
    Taken taken = FramedDecoder::decode(bytes.subspan(passed), received, frame);
    taken.bytes += passed;
    return taken;
}

/// Removes bytes behind the head of a long message, which the caller removes.
void MavlinkMessages::pass_over(std::size_t count) {
    while (count > 0 && buffer_.see(kLongHead + 1)) {
        buffer_.see(std::min(kLongHead + count, LineBuffer::kCapacity));
        const std::size_t here = std::min(count, buffer_.size() - kLongHead);
        buffer_.drop(here);
        count -= here;
    }
    passed_over_ = count;
}

std::size_t MavlinkMessages::needed_bytes(std::span<const std::uint8_t> bytes) const {
    if (bytes[0] != kVersion1 && bytes[0] != kVersion2) {
        return 0;
    }
    if (bytes.size() < 3) {
        return 3;
    }
    return is_long(bytes) ? kLongHead : whole_bytes(bytes);
}

bool MavlinkMessages::check_holds(std::span<const std::uint8_t> frame) const {
    if (is_long(frame)) {
        return true;
    }
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
    if (is_long(frame)) {
        pass_over(whole_bytes(frame) - kLongHead);
        return false;
    }
    const MavlinkHeader header = header_of(frame);
    const MessageKind* const kind = find_kind(header.id);
    const std::size_t length = frame[1];
    if (kind == nullptr || (frame[0] == kVersion1 && length < kind->length_1)) {
        return false;
    }
    if (verifier_) {
        if (!is_genuine(frame, header.id, channels.received)) {
            return false;
        }
        age_ = verifier_->delay();
    }
    MavlinkMessage message{.id = header.id, .system = header.system, .component = header.component};
    std::ranges::copy(frame.subspan(header.bytes, std::min<std::size_t>(length, kind->length)),
                      message.payload.begin());
    return take(message, channels);
}

}  // namespace tribus
