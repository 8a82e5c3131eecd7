#include "transports/codecs/crsf/handset.h"

#include <chrono>
#include <utility>

#include "transports/codecs/big_endian.h"
#include "transports/codecs/crsf/wire.h"
#include "transports/codecs/crsf/write.h"
#include "transports/codecs/protocol.h"

namespace tribus {

using namespace crsf_wire;

namespace {

// docs/protocols/crsf.md, "Towards a transmitter module".
constexpr std::uint8_t kCommandType = 0x32;
constexpr std::uint8_t kReceiverCommands = 0x10;
constexpr std::uint8_t kSelectModel = 0x05;
constexpr std::uint8_t kModuleMessageType = 0x3A;
constexpr std::uint8_t kTiming = 0x10;

/// CRC-8 with polynomial BA, the inner check of commands. One frame now and then: no table.
std::uint8_t command_check(std::span<const std::uint8_t> bytes) {
    unsigned crc = 0;
    for (const std::uint8_t byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc & 0x80U) != 0 ? (crc << 1U ^ 0xBAU) & 0xFFU : crc << 1U;
        }
    }
    return static_cast<std::uint8_t>(crc);
}

std::uint32_t word_at(std::span<const std::uint8_t> payload, std::size_t at) {
    return std::uint32_t{big_endian_at(payload, at)} << 16U | big_endian_at(payload, at + 2);
}

/// The wire counts in 0.1 us.
Duration tenths(std::int64_t count) {
    return std::chrono::nanoseconds(100 * count);
}

}  // namespace

std::uint32_t CrsfHandsetEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(kSbusChannels);
}

std::size_t CrsfHandsetEncoder::write(const ChannelFrame& frame,
                                      std::span<std::uint8_t, kLongestSerialFrame> wire,
                                      Instant now) {
    note_sending(now);
    if (std::exchange(heard_.appeared, false) && model_id_) {
        return write_model_id(wire);
    }
    return write_channels(frame, scale_, kTransmitter, wire);
}

void CrsfHandsetEncoder::note_sending(Instant now) {
    if (!sends_since_ || now - sent_at_ > kStoppedSending) {
        sends_since_ = now;
    }
    sent_at_ = now;
    if (std::exchange(unread_, false)) {
        unread_at_ = now;
    }
}

std::size_t CrsfHandsetEncoder::write_model_id(
    std::span<std::uint8_t, kLongestSerialFrame> wire) const {
    constexpr std::size_t kPayloadBytes = 6;
    wire[kTypeAt] = kCommandType;
    wire[kPayloadAt] = kTransmitter;
    wire[kPayloadAt + 1] = kHandset;
    wire[kPayloadAt + 2] = kReceiverCommands;
    wire[kPayloadAt + 3] = kSelectModel;
    wire[kPayloadAt + 4] = *model_id_;
    wire[kPayloadAt + 5] =
        command_check(std::span<const std::uint8_t>(wire).subspan<kTypeAt, kPayloadBytes>());
    return finish_frame<kPayloadBytes>(kTransmitter, kCommandType, wire);
}

std::optional<AskedTiming> CrsfHandsetEncoder::hear(std::span<const std::uint8_t> bytes,
                                                    Instant now) {
    std::optional<AskedTiming> asked;
    DecodedFrame frame;
    const std::uint64_t refused = heard_.refused();
    while (heard_.next(bytes, now, frame)) {
        asked = heard_.timing;
    }
    unread_ = unread_ || heard_.refused() != refused;
    return asked;
}

/// Damaged bytes are not told in another way.
void CrsfHandsetEncoder::forget_heard() {
    heard_.reset();
    unread_ = true;
}

Hearing CrsfHandsetEncoder::hearing(Instant now) const {
    if (heard_.heard_at && now - *heard_.heard_at < kModuleGone) {
        return Hearing::heard;
    }
    if (!sends_since_ || now - sent_at_ > kStoppedSending || now - *sends_since_ < kFirstWordWait) {
        return Hearing::not_awaited;
    }
    return unread_at_ && now - *unread_at_ < kModuleGone ? Hearing::unreadable : Hearing::silent;
}

void CrsfHandsetEncoder::continue_from(const Encoder& before) {
    if (const auto* same = dynamic_cast<const CrsfHandsetEncoder*>(&before)) {
        heard_.heard_at = same->heard_.heard_at;
        heard_.appeared = heard_.heard_at && model_id_ != same->model_id_;
        sends_since_ = same->sends_since_;
        sent_at_ = same->sent_at_;
        unread_at_ = same->unread_at_;
    }
}

std::uint64_t CrsfHandsetEncoder::FromModule::refused() const {
    std::uint64_t count = skipped_bytes();
    for (const NamedCount& cause : rejected()) {
        count += cause.count;
    }
    return count;
}

/// Modules put the handset's address first, those of ExpressLRS 4 the sync byte, which is that of a
/// flight controller. Own frames that come back begin with the module's address.
/// Returns whether the frame says which timing the module wants.
bool CrsfHandsetEncoder::FromModule::read(std::span<const std::uint8_t> frame,
                                          ChannelFrame& channels) {
    constexpr std::size_t kPeriodAt = 3;
    constexpr std::size_t kOffsetAt = 7;
    constexpr std::size_t kTimingBytes = 11;
    if (frame[0] != kHandset && frame[0] != kFlightController) {
        return false;
    }
    const Instant now = channels.received;
    appeared = appeared || !heard_at || now - *heard_at >= kModuleGone;
    heard_at = now;
    const auto payload = payload_of(frame);
    if (frame[kTypeAt] != kModuleMessageType || payload.size() < kTimingBytes ||
        payload[0] != kHandset || payload[2] != kTiming || word_at(payload, kPeriodAt) == 0) {
        return false;
    }
    timing = {.period = tenths(word_at(payload, kPeriodAt)),
              .later = tenths(static_cast<std::int32_t>(word_at(payload, kOffsetAt)))};
    return true;
}

}  // namespace tribus
