#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/arrival_clock.h"
#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/sensor_bus/echo_canceller.h"
#include "pipelines/sensor_bus/role.h"
#include "transports/codecs/ibus_sensor.h"
#include "transports/codecs/ibus_sensor_types.h"

namespace tribus {

/// Where a field of a sensor's value comes from: number = value * factor + offset.
struct FieldSource {
    std::size_t value = 0;  ///< on the board
    double factor = 1;
    double offset = 0;
};

struct SensorSettings {
    SensorType type;
    /// One for each field of the type. A field without a source is "not available", or zero where
    /// the type has no code for that.
    std::vector<std::optional<FieldSource>> sources;
    /// A number that is sent for a value that is stale, where the type has no code for that;
    /// absent: the sensor does not answer.
    std::optional<double> when_stale{};
};

struct SensorRoleSettings {
    /// Of the first sensor, the others follow; absent: that of the first discover request that
    /// comes, as genuine sensors in a daisy chain do (docs/protocols/ibus.md, "Sensor bus:
    /// addresses").
    std::optional<std::uint8_t> first_address = 1;
    std::vector<SensorSettings> sensors{};
    /// One wire for both directions: what is sent comes back.
    bool hears_itself = true;
    /// An answer leaves so long after its request was read, and not at all after `reply_within`:
    /// 0.1 to 1 ms is proven with genuine receivers (docs/protocols/ibus.md, "Sensor bus: answer
    /// times").
    Duration reply_after = std::chrono::microseconds(200);
    Duration reply_within = std::chrono::milliseconds(1);
};

/// Events since start. Only ever incremented.
struct SensorRoleCounts {
    std::uint64_t requests = 0;  ///< of whatever address
    std::uint64_t answered = 0;  ///< with the kernel
    std::uint64_t late = 0;      ///< withheld: too late for its slot
    std::uint64_t stale = 0;     ///< value requests without an answer, for there is no number
    std::uint64_t dropped = 0;   ///< the port took nothing
};

/// The appliance as up to 15 sensors of a receiver. Answers are worked out before they are asked
/// for; one that cannot leave in its own slot is withheld.
///
/// A stall of this program is seen in three ways: something else already follows the request, the
/// turn comes too late, or the request was read late by the rhythm of those before it.
class SensorRole final : public SensorBusRole {
  public:
    explicit SensorRole(SensorRoleSettings settings);

    void start(Instant now) override;
    /// Goes on as `before`, a role with the same settings but for the places of its values.
    void continue_from(const SensorRole& before);
    void receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) override;
    void damaged_byte(Instant now) override;
    Instant due() const override { return pending_ ? reply_at_ : kNever; }
    std::span<const std::uint8_t> run(Instant now, ValueBoard& board) override;
    void written(Instant now, ValueBoard& board) override;
    void dropped() override { ++counts_.dropped; }
    void device_lost(ValueBoard& board) override;

    const SensorRoleCounts& counts() const { return counts_; }
    const EchoCounts& echo() const { return echo_.counts(); }
    const SensorFrameParser& parser() const { return parser_; }
    /// Of the first sensor; absent while it waits for one.
    std::optional<std::uint8_t> first_address() const { return first_address_; }
    /// When the latest request came, of whatever address.
    std::optional<Instant> latest_request() const { return latest_request_; }

  private:
    struct Answer {
        std::array<std::uint8_t, kMostSensorData> data{};
        bool available = false;
        Instant until = kNever;
    };

    void take(const SensorFrame& frame, Instant now, bool more_follows, ValueBoard& board);
    void answer(const SensorFrame& frame, std::size_t sensor, Instant now, ValueBoard& board);
    bool prepare_reply(const SensorFrame& frame, std::size_t sensor, Instant now,
                       ValueBoard& board);
    void withhold();
    bool read_late(Instant now);
    void prepare_all(Instant now, const ValueBoard& board);
    void prepare(std::size_t sensor, Instant now, const ValueBoard& board);
    bool fill(std::size_t sensor, std::size_t field, Instant now, const ValueBoard& board);

    SensorRoleSettings settings_;
    SensorFrameParser parser_;
    EchoCanceller echo_;
    ArrivalClock requests_;
    std::optional<std::uint8_t> first_address_;
    std::optional<Instant> latest_request_;
    std::vector<Answer> answers_;
    Instant prepared_at_{};

    bool pending_ = false;
    std::array<std::uint8_t, kLongestSensorFrame> reply_{};
    std::size_t reply_length_ = 0;
    Instant reply_at_{};
    Instant reply_until_{};
    int rhythm_belief_ = 0;
    SensorRoleCounts counts_;
};

}  // namespace tribus
