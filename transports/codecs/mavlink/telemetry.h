#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "transports/codecs/mavlink/messages.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/value_reader.h"

namespace tribus {

extern const Protocol kMavlinkTelemetryProtocol;

/// Reads the state of an autopilot (docs/protocols/mavlink.md, "Telemetry"): component 1 of the
/// first system heard, and the first radio. What the autopilot marks as unknown is not available.
class MavlinkTelemetryReader final : public ByteValueReader {
  public:
    /// With `key`, only what is signed with it counts, and RADIO_STATUS, which radios add unsigned.
    explicit MavlinkTelemetryReader(const std::optional<SecretKey>& key = std::nullopt);

    /// "battery.voltage", "gps.latitude", "attitude.roll" and so on.
    std::span<const Value> values() const override { return values_; }
    std::span<const NamedCount> rejected() const override { return messages_.rejected(); }
    std::uint64_t skipped_bytes() const override { return messages_.skipped_bytes(); }
    bool next(std::span<const std::uint8_t>& bytes, Instant received,
              std::span<ValueReading> readings) override;
    void damaged_byte() override { messages_.damaged_byte(); }
    void reset() override { messages_.reset(); }
    void use_clock(const WallClock& clock) override { messages_.use_clock(clock); }

  private:
    /// Keeps the numbers of the latest message.
    class Messages final : public MavlinkMessages {
      public:
        explicit Messages(const std::optional<SecretKey>& key) : MavlinkMessages(key) {}
        std::vector<ValueReading> readings;

      private:
        bool take(const MavlinkMessage& message, ChannelFrame& channels) override;
        bool takes_unsigned(std::uint32_t id) const override {
            return id == mavlink_wire::kRadioStatus.id;
        }
        bool is_from_autopilot(const MavlinkMessage& message, Instant received);

        MavlinkSender autopilot_;
        MavlinkSender radio_;
    };

    std::vector<Value> values_;
    Messages messages_;
};

}  // namespace tribus
