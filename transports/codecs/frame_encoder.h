#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/transmission.h"

namespace tribus {

/// An encoder, by what leaves it.
using AnyEncoder = std::variant<std::unique_ptr<ByteEncoder>, std::unique_ptr<CanEncoder>>;

/// An encoder with room for what it encodes. No heap after construction. Thread-bound.
class FrameEncoder {
  public:
    explicit FrameEncoder(AnyEncoder encoder)
        : encoder_(std::move(encoder)), frames_(on_can() ? kMostSnapshotFrames : 0) {}

    Encoder& encoder() {
        return std::visit([](const auto& any) -> Encoder& { return *any; }, encoder_);
    }
    const Encoder& encoder() const {
        return std::visit([](const auto& any) -> const Encoder& { return *any; }, encoder_);
    }
    bool on_can() const { return std::holds_alternative<std::unique_ptr<CanEncoder>>(encoder_); }

    /// Encodes one frame that is sent at `now`. Valid until the next call.
    Transmission encode(const ChannelFrame& frame, Instant now) {
        if (const auto* bytes = std::get_if<std::unique_ptr<ByteEncoder>>(&encoder_)) {
            const std::size_t length = (*bytes)->write(frame, wire_, now);
            return Transmission(std::span<const std::uint8_t>(wire_).first(length));
        }
        const std::span<CanFrame, kMostSnapshotFrames> room(frames_);
        const auto& can = std::get<std::unique_ptr<CanEncoder>>(encoder_);
        return Transmission(std::span<const CanFrame>(room).first(can->write(frame, room, now)));
    }

    /// The same while the output is silent. Empty in most protocols.
    Transmission encode_silence(Instant now) {
        const auto* bytes = std::get_if<std::unique_ptr<ByteEncoder>>(&encoder_);
        const std::size_t length = bytes != nullptr ? (*bytes)->write_silence(wire_, now) : 0;
        return Transmission(std::span<const std::uint8_t>(wire_).first(length));
    }

    /// See ByteEncoder, and CanEncoder. Nothing on the other medium.
    std::optional<AskedTiming> hear(std::span<const std::uint8_t> bytes, Instant now) {
        const auto* encoder = std::get_if<std::unique_ptr<ByteEncoder>>(&encoder_);
        return encoder != nullptr ? (*encoder)->hear(bytes, now) : std::nullopt;
    }
    void hear(const CanFrame& frame, Instant received) {
        if (const auto* encoder = std::get_if<std::unique_ptr<CanEncoder>>(&encoder_)) {
            (*encoder)->hear(frame, received);
        }
    }
    /// Empty on other media than CAN.
    std::span<const CanIdMatch> heard() const {
        const auto* encoder = std::get_if<std::unique_ptr<CanEncoder>>(&encoder_);
        return encoder != nullptr ? (*encoder)->heard() : std::span<const CanIdMatch>{};
    }
    void forget_heard() {
        if (const auto* encoder = std::get_if<std::unique_ptr<ByteEncoder>>(&encoder_)) {
            (*encoder)->forget_heard();
        }
    }

  private:
    AnyEncoder encoder_;
    std::array<std::uint8_t, kLongestSerialFrame> wire_{};
    /// Room for kMostSnapshotFrames on CAN, else empty.
    std::vector<CanFrame> frames_;
};

}  // namespace tribus
