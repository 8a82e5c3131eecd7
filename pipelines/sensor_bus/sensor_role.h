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
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/codecs/ibus_sensor/types.h"

namespace tribus {

/// Source of a field of a sensor's value: number = value * factor + offset.
struct FieldSource {
    std::size_t value = 0;  ///< index on the board
    double factor = 1;
    double offset = 0;
};

struct SensorSettings {
    SensorType type;
    /// One for each field of the type. A field without a source is sent as "not available", or as
    /// zero if the type has no code for that.
    std::vector<std::optional<FieldSource>> sources;
    /// Number that is sent in place of a stale value if the type has no code "not available".
    /// Absent: the sensor does not answer.
    std::optional<double> when_stale{};
};

/// Usual delays of an answer. Genuine receivers are proven to accept 0.1 to 1 ms
/// (docs/protocols/ibus.md, "Sensor bus: answer times").
inline constexpr Duration kUsualReplyAfter = std::chrono::microseconds(200);
inline constexpr Duration kUsualReplyWithin = std::chrono::milliseconds(1);

struct SensorRoleSettings {
    /// Address of the first sensor; the others follow. Absent: the address of the first discover
    /// request, as for genuine sensors in a daisy chain (docs/protocols/ibus.md, "Sensor bus:
    /// addresses").
    std::optional<std::uint8_t> first_address = 1;
    std::vector<SensorSettings> sensors{};
    /// One wire for both directions: sent bytes come back.
    bool receives_echo = true;
    /// Delay of an answer after its request was read. After `reply_within` it is not sent at all.
    Duration reply_after = kUsualReplyAfter;
    Duration reply_within = kUsualReplyWithin;
};

/// Counters since the start. They never decrease.
struct SensorRoleCounts {
    std::uint64_t requests = 0;  ///< for any address
    std::uint64_t answered = 0;  ///< handed over to the kernel
    std::uint64_t late = 0;      ///< not sent: too late for its slot
    std::uint64_t stale = 0;     ///< value requests without an answer because there is no number
    std::uint64_t dropped = 0;   ///< the port took nothing
};

/// The program in the role of up to 15 sensors. Answers are prepared before the request comes. An
/// answer that would miss its own slot is not sent.
///
/// A delay of this program shows in three ways: further bytes already follow the request, `run` is
/// called too late, or the request was read late compared with the period of the requests before.
class SensorRole final : public SensorBusRole {
  public:
    explicit SensorRole(SensorRoleSettings settings);

    void start(Instant now) override;
    /// Takes over the state of `before`, a role with the same settings except the indices on the
    /// board.
    void continue_from(const SensorRole& before);
    void receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) override;
    void damaged_byte(Instant now) override;
    Instant due() const override { return ongoing_.pending ? ongoing_.reply_at : kNever; }
    std::span<const std::uint8_t> run(Instant now, ValueBoard& board) override;
    void written(Instant now, ValueBoard& board) override;
    void dropped() override { ++ongoing_.counts.dropped; }
    void device_lost(ValueBoard& board) override;

    const SensorRoleCounts& counts() const { return ongoing_.counts; }
    const EchoCounts& echo() const { return ongoing_.echo.counts(); }
    const SensorFrameParser& parser() const { return ongoing_.parser; }
    /// Address of the first sensor. Absent while it waits for one.
    std::optional<std::uint8_t> first_address() const { return ongoing_.first_address; }
    /// When the latest request came, for any address.
    std::optional<Instant> latest_request() const { return ongoing_.latest_request; }

  private:
    struct Answer {
        std::array<std::uint8_t, kMostSensorData> data{};
        bool available = false;
        Instant until = kNever;
    };

    /// A reload keeps this state, besides the prepared answers.
    struct Ongoing {
        SensorFrameParser parser{};
        EchoCanceller echo{};
        ArrivalClock requests{};
        std::optional<std::uint8_t> first_address{};
        std::optional<Instant> latest_request{};
        Instant prepared_at{};
        bool pending = false;
        std::array<std::uint8_t, kLongestSensorFrame> reply{};
        std::size_t reply_length = 0;
        Instant reply_at{};
        Instant reply_until{};
        int period_confidence = 0;
        SensorRoleCounts counts{};
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
    std::vector<Answer> answers_;
    Ongoing ongoing_;
};

}  // namespace tribus
