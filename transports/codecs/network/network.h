#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/random_seed.h"
#include "core/time.h"
#include "transports/codecs/authenticated/messages.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/native_can/channels_layout.h"
#include "transports/codecs/protocol.h"

/// The messages of the native CAN FD format in datagrams (docs/protocols/network.md). The format is
/// tribus' own. A frame: 54 52 ("TR"), version 01, length of the message, the message: 24, 32 or 64
/// bytes of a link with a key (transports/codecs/authenticated), or 48 bytes of a link without one
/// (transports/codecs/native_can).
namespace tribus {

extern const Protocol kNetworkProtocol;

namespace network {

inline constexpr std::uint8_t kFirstByte = 0x54;
inline constexpr std::uint8_t kSecondByte = 0x52;
inline constexpr std::uint8_t kVersion = 1;
inline constexpr std::size_t kLengthAt = 3;
inline constexpr std::array<std::uint8_t, kLengthAt> kBeginning{kFirstByte, kSecondByte, kVersion};
inline constexpr std::size_t kHeadBytes = 4;
inline constexpr std::size_t kPlainBytes = can_channels::kFdLength;
/// A hello and a snapshot, each with its head.
inline constexpr std::size_t kLongestFrame =
    2 * kHeadBytes + authenticated::kHelloBytes + authenticated::kSnapshotBytes;

}  // namespace network

/// Hands the messages to a decoder of CAN FD frames.
class NetworkDecoder final : public FramedDecoder {
  public:
    explicit NetworkDecoder(std::unique_ptr<CanDecoder> messages);

    void use_seed(const RandomSeed& seed) override { messages_->use_seed(seed); }
    void use_random(RandomSource random) override { messages_->use_random(random); }
    void use_numbers(NumberReservation& numbers) override { messages_->use_numbers(numbers); }
    std::span<const std::uint8_t> answer(Instant now) override;
    LinkCause why_garbled() const override { return messages_->why_garbled(); }
    std::size_t write_fault(std::span<char> text) const override {
        return messages_->write_fault(text);
    }
    void use_keys_of(const DecoderReport& fresh) override;
    std::span<const FrameDetail> details() const override { return messages_->details(); }

  private:
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;
    void count_refusals();

    std::unique_ptr<CanDecoder> messages_;
    /// The causes of `messages_` that frames in datagrams can have: their places there, and what
    /// was counted so far.
    std::vector<std::size_t> causes_;
    std::vector<std::uint64_t> counted_;
    std::array<std::uint8_t, network::kLongestFrame> answer_{};
};

/// Hands snapshots to an encoder of CAN FD frames.
class NetworkEncoder final : public ByteEncoder {
  public:
    explicit NetworkEncoder(std::unique_ptr<CanEncoder> messages)
        : messages_(std::move(messages)), frames_(kMostSnapshotFrames) {}

    bool marks_frame_lost() const override { return messages_->marks_frame_lost(); }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override {
        return messages_->needed_channels(frame);
    }
    bool may_withhold() const override { return messages_->may_withhold(); }
    Withheld withheld() const override { return messages_->withheld(); }
    void use_seed(const RandomSeed& seed) override { messages_->use_seed(seed); }
    void use_numbers(NumberReservation& numbers) override { messages_->use_numbers(numbers); }
    void continue_from(const Encoder& before) override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
    std::optional<AskedTiming> hear(std::span<const std::uint8_t> bytes, Instant now) override;

  private:
    std::unique_ptr<CanEncoder> messages_;
    std::vector<CanFrame> frames_;
};

}  // namespace tribus
