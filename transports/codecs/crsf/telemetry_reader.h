#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "transports/codecs/crsf/frames.h"
#include "transports/codecs/value_reader.h"

namespace tribus {

/// Reads the messages of CRSF telemetry (docs/protocols/crsf.md, "Telemetry"), as a flight
/// controller or a transmitter module sends them. A longer message than usual is taken, a shorter
/// one is not. Passes over numbered values of another source than 0, texts, and frames of other
/// types.
class CrsfTelemetryReader final : public ByteValueReader {
  public:
    CrsfTelemetryReader();

    /// Their names are those of kTelemetryMessages and kReadMessages: "battery.voltage", "vario",
    /// "cells.1".
    std::span<const Value> values() const override { return values_; }
    std::span<const NamedCount> rejected() const override { return frames_.rejected(); }
    std::uint64_t skipped_bytes() const override { return frames_.skipped_bytes(); }
    bool next(std::span<const std::uint8_t>& bytes, Instant received,
              std::span<ValueReading> readings) override;
    void damaged_byte() override { frames_.damaged_byte(); }
    void reset() override { frames_.reset(); }

  private:
    /// Keeps the numbers of the latest message.
    class Frames final : public CrsfFrames {
      public:
        std::vector<ValueReading> readings;

      private:
        bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;
    };

    std::vector<Value> values_;
    Frames frames_;
};

}  // namespace tribus
