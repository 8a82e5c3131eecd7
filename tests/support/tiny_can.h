#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "app/cli/protocol_use.h"
#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/protocol.h"

/// The smallest CAN protocol: channel 1 as two bytes of microseconds under one id, the high byte
/// first. For tests of the code around a codec.
namespace tribus::test {

inline constexpr CanIdMatch kTinyId{.id = 0x123, .mask = kMostExtendedId, .extended = false};
inline constexpr CanIdMatch kOtherTinyId{.id = 0x124, .mask = kMostExtendedId, .extended = false};

class TinyCanDecoder final : public CanDecoder {
  public:
    explicit TinyCanDecoder(const CanIdMatch& id) : ids_{id} {}
    std::span<const CanIdMatch> wanted() const override { return ids_; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override {
        if (frame.length != 2 || frame.remote) {
            ++rejected_[0].count;
            return std::nullopt;
        }
        ChannelFrame snapshot;
        snapshot.frame_lost = false;
        snapshot.failsafe = false;
        snapshot.received = received;
        snapshot.set(0, Pulse::from_fractional_microseconds(frame.data[0] * 256 + frame.data[1]));
        return snapshot;
    }
    std::span<const NamedCount> rejected() const override { return rejected_; }

  private:
    std::array<CanIdMatch, 1> ids_;
    std::array<NamedCount, 1> rejected_{{{"length"}}};
};

class TinyCanEncoder final : public CanEncoder {
  public:
    bool marks_frame_lost() const override { return false; }
    std::span<const CanIdMatch> sent() const override { return std::span(&kTinyId, 1); }
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 1; }
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant /*now*/) override {
        const int pulse = snapshot.channel_or(0, Pulse{}).whole_microseconds();
        frames[0] = CanFrame{};
        frames[0].id = kTinyId.id;
        frames[0].length = 2;
        frames[0].data[0] = static_cast<std::uint8_t>(pulse / 256);
        frames[0].data[1] = static_cast<std::uint8_t>(pulse % 256);
        return 1;
    }
};

inline const Protocol kTinyCan{
    .name = "tiny",
    .title = "tiny",
    .description = "For tests",
    .shape = WireShape::can_frames,
    .line = {},
    .settings = {},
    .default_period = std::chrono::milliseconds(20),
    .signals_failsafe = never_signals_failsafe,
    .make_decoder = [](const SettingValues&) -> AnyDecoder {
        return std::make_unique<TinyCanDecoder>(kTinyId);
    },
    .make_encoder = [](const SettingValues&) -> AnyEncoder {
        return std::make_unique<TinyCanEncoder>();
    },
};

/// The same protocol under the id 0x124. It only reads.
inline const Protocol kOtherTinyCan{
    .name = "other",
    .title = "tiny",
    .description = "For tests",
    .shape = WireShape::can_frames,
    .line = {},
    .settings = {},
    .make_decoder = [](const SettingValues&) -> AnyDecoder {
        return std::make_unique<TinyCanDecoder>(kOtherTinyId);
    },
};

inline ProtocolUse use_of(const Protocol& protocol) {
    return {.protocol = &protocol, .settings = {}, .line = {}};
}

}  // namespace tribus::test
