#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "transports/codecs/mavlink/messages.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/value_reader.h"

namespace tribus {

extern const Protocol kMavlinkTelemetryProtocol;

/// Reads the state of an autopilot (docs/protocols/mavlink.md, "Telemetry"): component 1 of the
/// first system heard. What the autopilot marks as unknown is not available.
class MavlinkTelemetryReader final : public ByteValueReader {
  public:
    MavlinkTelemetryReader();

    /// "battery.voltage", "gps.latitude", "attitude.roll" and so on.
    std::span<const Value> values() const override { return values_; }
    std::span<const NamedCount> rejected() const override { return messages_.rejected(); }
    std::uint64_t skipped_bytes() const override { return messages_.skipped_bytes(); }
    bool next(std::span<const std::uint8_t>& bytes, Instant received,
              std::span<ValueReading> readings) override;
    void damaged_byte() override { messages_.damaged_byte(); }
    void reset() override { messages_.reset(); }

  private:
    /// Keeps the numbers of the latest message.
    class Messages final : public MavlinkMessages {
      public:
        std::vector<ValueReading> readings;

      private:
        bool take(const MavlinkMessage& message, ChannelFrame& channels) override;
        bool is_from_autopilot(const MavlinkMessage& message, Instant received);

        MavlinkSender sender_;
    };

    std::vector<Value> values_;
    Messages messages_;
};

}  // namespace tribus
