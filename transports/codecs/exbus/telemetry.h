#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/setting.h"
#include "core/value_board.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/exbus/exbus.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/sent_number.h"

/// Telemetry of Jeti EX Bus: named values in answers to the receiver's requests
/// (docs/protocols/exbus.md, "Telemetry").
namespace tribus {

extern const Protocol kExBusTelemetryProtocol;

/// How a number is written.
enum class ExBusNumber : std::uint8_t { decimal, latitude, longitude };

/// A number on the transmitter's display.
struct ExBusSensor {
    std::uint8_t number = 1;  ///< 1 to 15
    std::string value;        ///< name
    std::string label;        ///< at most kMostLabel letters
    /// What the value is converted to, at most kMostUnit letters. Empty: the unit of the value.
    std::string unit;
    int decimals = 2;  ///< at most 3
    ExBusNumber form = ExBusNumber::decimal;

    static constexpr std::size_t kMostLabel = 11;
    static constexpr std::size_t kMostUnit = 5;
};

/// A device with its sensors, as the transmitter lists it.
struct ExBusDevice {
    std::string name;  ///< at most kMostName letters
    std::uint16_t number = 1;
    std::vector<ExBusSensor> sensors;  ///< at least 1

    static constexpr std::size_t kMostName = 16;
};

/// The device that the settings describe. Adds what is wrong to `mistakes`. For the start.
ExBusDevice exbus_device(const SettingValues& settings, std::vector<SettingMistake>& mistakes);

/// Answers each request for telemetry with one frame: as many fresh numbers as fit, in turn, or the
/// name of the device or of a sensor. First it sends all names, then one after each
/// kNumbersPerName frames of numbers. If no number is fresh it does not answer.
class ExBusTelemetryEncoder final : public ByteEncoder {
  public:
    explicit ExBusTelemetryEncoder(ExBusDevice device);

    void use(const ValueBoard& board) override;
    std::uint32_t needed_channels(const ChannelFrame& /*frame*/) const override { return 0; }
    bool marks_frame_lost() const override { return false; }
    /// Returns 0 without a request, or if its answer would come too late.
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
    /// Only a request at the end of `bytes` asks for a frame: behind another one comes what the
    /// receiver sends next.
    std::optional<AskedTiming> hear(std::span<const std::uint8_t> bytes, Instant now) override;
    void forget_heard() override;

    /// A receiver waits 4 ms. Betaflight begins no answer after 3 ms; a read may come 1 ms late.
    static constexpr Duration kMostDelay = std::chrono::milliseconds(2);
    static constexpr int kNumbersPerName = 10;

  private:
    class Requests final : public ExBusFrames {
      public:
        std::uint8_t packet = 0;  ///< number of the latest request

      private:
        bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;
    };
    struct Request {
        std::uint8_t packet = 0;
        Instant at{};
    };

    bool any_fresh(Instant now) const;
    std::size_t write_name(std::span<std::uint8_t> wire) const;
    std::size_t write_numbers(std::span<std::uint8_t> wire, Instant now);
    std::size_t write_number(std::size_t index, double value, std::span<std::uint8_t> wire) const;

    ExBusDevice device_;
    std::vector<SentNumber> numbers_;  ///< for each sensor
    std::vector<std::string> units_;   ///< as shown, for each sensor
    Requests heard_;
    std::uint64_t heard_bytes_ = 0;
    Instant heard_at_{};
    std::optional<Request> asked_;
    std::size_t next_name_ = 0;  ///< 0: the device; else the sensor with the index before
    std::size_t next_number_ = 0;
    /// Frames of numbers until the next name.
    int numbers_left_ = 0;
    bool all_named_ = false;
};

}  // namespace tribus
