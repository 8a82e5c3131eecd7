#include <cstddef>
#include <cstdint>

#include "tests/reference/plain_sbus.h"
#include "tests/reference/plain_sbus_wire.h"

/// A frame of SBUS to and from its bytes.
namespace tribus::reference {

using namespace plain_sbus_wire;

namespace {

constexpr std::size_t kPayloadAt = 1;
constexpr unsigned kBitsPerChannel = 11;

constexpr std::uint8_t kChannel17Flag = 0x01;
constexpr std::uint8_t kChannel18Flag = 0x02;
constexpr std::uint8_t kFrameLostFlag = 0x04;
constexpr std::uint8_t kFailsafeFlag = 0x08;

static_assert(kPayloadAt + kSbusChannels * kBitsPerChannel / 8 == kFlagsAt);
static_assert(kFooterAt + 1 == kSbusFrameLength);

}  // namespace

SbusFrame plain_parse_sbus(std::span<const std::uint8_t, kSbusFrameLength> wire) {
    SbusFrame frame;
    std::uint32_t bits = 0;
    unsigned bit_count = 0;
    std::size_t position = kPayloadAt;
    for (std::uint16_t& raw : frame.raw) {
        while (bit_count < kBitsPerChannel) {
            bits |= static_cast<std::uint32_t>(wire[position++]) << bit_count;
            bit_count += 8;
        }
        raw = static_cast<std::uint16_t>(bits & kSbusRawMost);
        bits >>= kBitsPerChannel;
        bit_count -= kBitsPerChannel;
    }
    const std::uint8_t flags = wire[kFlagsAt];
    frame.channel_17 = (flags & kChannel17Flag) != 0;
    frame.channel_18 = (flags & kChannel18Flag) != 0;
    frame.frame_lost = (flags & kFrameLostFlag) != 0;
    frame.failsafe = (flags & kFailsafeFlag) != 0;
    frame.footer = wire[kFooterAt];
    return frame;
}

void plain_emit_sbus(const SbusFrame& frame, std::span<std::uint8_t, kSbusFrameLength> wire) {
    wire[0] = kHeader;
    std::uint32_t bits = 0;
    unsigned bit_count = 0;
    std::size_t position = kPayloadAt;
    for (const std::uint16_t raw : frame.raw) {
        bits |= static_cast<std::uint32_t>(raw & kSbusRawMost) << bit_count;
        bit_count += kBitsPerChannel;
        while (bit_count >= 8) {
            wire[position++] = static_cast<std::uint8_t>(bits);
            bits >>= 8U;
            bit_count -= 8;
        }
    }
    unsigned flags = 0;
    flags |= frame.channel_17 ? kChannel17Flag : 0U;
    flags |= frame.channel_18 ? kChannel18Flag : 0U;
    flags |= frame.frame_lost ? kFrameLostFlag : 0U;
    flags |= frame.failsafe ? kFailsafeFlag : 0U;
    wire[kFlagsAt] = static_cast<std::uint8_t>(flags);
    wire[kFooterAt] = frame.footer;
}

std::size_t PlainSbusEncoder::encode(const ChannelFrame& frame,
                                     std::span<std::uint8_t, kLongestSerialFrame> wire) const {
    SbusFrame out;
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        out.raw[channel] = scale_.encode(frame.channel_or(channel, kCentrePulse));
    }
    out.channel_17 = frame.channel_or(16, kSwitchOffPulse) > kCentrePulse;
    out.channel_18 = frame.channel_or(17, kSwitchOffPulse) > kCentrePulse;
    out.frame_lost = frame.frame_lost;
    out.failsafe = frame.failsafe;
    plain_emit_sbus(out, wire.first<kSbusFrameLength>());
    return kSbusFrameLength;
}

}  // namespace tribus::reference
