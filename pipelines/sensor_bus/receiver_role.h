#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/sensor_bus/echo_canceller.h"
#include "pipelines/sensor_bus/role.h"
#include "transports/codecs/ibus_sensor.h"
#include "transports/codecs/ibus_sensor_types.h"

namespace tribus {

/// Where the reading of one sensor goes on the board: its raw value and its first fields.
struct ReadingPlaces {
    std::size_t raw = 0;
    std::vector<std::size_t> fields;
};

/// Where the reading of the first sensor of a type goes as well.
struct TypePlaces {
    std::uint8_t type = 0;
    std::vector<std::size_t> fields;
};

/// Automatic: what comes back of the power-up frames, which nobody answers, tells it.
enum class Wires : std::uint8_t { automatic, one, two };

struct ReceiverRoleSettings {
    /// One request each (docs/protocols/ibus.md, "Sensor bus: timing").
    Duration slot = std::chrono::microseconds(7700);
    Wires wires = Wires::automatic;
    /// Begins as genuine receivers do. Without it `automatic` means one wire.
    bool power_up_frames = true;
    /// Slots from one look for a further sensor to the next.
    int probe_every = 66;
    /// So many requests in a row without an answer: the sensor is gone, and those behind it.
    int drop_after = 66;
    SensorTypes types = SensorTypes();
    std::array<ReadingPlaces, kMostSensors> readings{};
    std::vector<TypePlaces> first_of_type{};
};

/// A sensor that was found.
struct FoundSensor {
    std::uint8_t type = 0;
    std::uint8_t size = 0;

    bool operator==(const FoundSensor&) const = default;
};

/// Events since start. Only ever incremented.
struct ReceiverRoleCounts {
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
    std::uint64_t misses = 0;  ///< type and value requests without an answer
    std::uint64_t wrong = 0;   ///< answers to something else, or of another size
    std::uint64_t lost_sensors = 0;
    std::uint64_t dropped = 0;  ///< requests that the port did not take
};

/// The appliance as the receiver: finds sensors, polls them in turn, and puts what they say on the
/// board (docs/protocols/ibus.md, "Sensor bus: timing" and "Sensor bus: the role of a receiver").
class ReceiverRole final : public SensorBusRole {
  public:
    explicit ReceiverRole(ReceiverRoleSettings settings);

    void start(Instant now) override;
    /// Goes on as `before`, a role with the same settings but for the places of its readings.
    void continue_from(const ReceiverRole& before);
    void receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) override;
    void damaged_byte(Instant now) override;
    Instant due() const override { return next_slot_; }
    std::span<const std::uint8_t> run(Instant now, ValueBoard& board) override;
    void written(Instant now, ValueBoard& board) override;
    void dropped() override;
    void device_lost(ValueBoard& board) override;

    /// Those that answer, from address 1 on.
    std::span<const FoundSensor> found() const { return {found_.data(), found_count_}; }
    const ReceiverRoleCounts& counts() const { return counts_; }
    const EchoCounts& echo() const { return echo_.counts(); }
    const SensorFrameParser& parser() const { return parser_; }

  private:
    enum class Stage : std::uint8_t { power_up, silence, polling };

    struct Request {
        SensorCommand command = SensorCommand::discover;
        std::uint8_t address = 1;

        bool operator==(const Request&) const = default;
    };
    /// A sensor that answers, and how its bytes are read.
    struct Sensor {
        /// Null: a type, or a size, that the table does not know.
        const SensorType* type = nullptr;
        /// Null: it is not the first of its type, or nobody asks by that name.
        const TypePlaces* by_type = nullptr;
        int misses = 0;
    };

    void conclude(ValueBoard& board);
    void value_missed(std::uint8_t address, ValueBoard& board);
    std::optional<Request> next_request();
    Request next_poll();
    std::span<const std::uint8_t> send(const Request& request);
    void take(const SensorFrame& frame, Instant now, ValueBoard& board);
    void add_sensor(const SensorFrame& frame);
    const SensorType* type_of(const FoundSensor& found) const;
    const TypePlaces* places_of_first(std::uint8_t type) const;
    void read_value(std::size_t sensor, std::span<const std::uint8_t> data, Instant now,
                    ValueBoard& board);
    void drop_from(std::size_t sensor, ValueBoard& board);
    void forget_reading(std::size_t sensor, ValueBoard& board);
    bool hears_itself() const;

    ReceiverRoleSettings settings_;
    /// By id: the code of the table itself runs at the start only.
    std::array<const SensorType*, 256> types_by_id_{};
    /// The types of the table with the other usual size, for sensors that say that one.
    std::vector<SensorType> resized_;
    SensorFrameParser parser_;
    EchoCanceller echo_;
    Stage stage_ = Stage::power_up;
    int slots_in_stage_ = 0;
    Instant next_slot_ = kNever;

    /// The request of this slot, while it has no answer.
    std::optional<Request> open_;
    /// What the next slot asks, where something is to follow at once.
    std::optional<Request> follow_up_;
    bool repeated_ = false;
    std::size_t next_polled_ = 0;
    int slots_since_probe_ = 0;
    std::array<std::uint8_t, kLongestSensorFrame> wire_{};
    std::size_t wire_length_ = 0;

    std::array<FoundSensor, kMostSensors> found_{};
    std::array<Sensor, kMostSensors> sensors_{};
    std::size_t found_count_ = 0;
    ReceiverRoleCounts counts_;
};

}  // namespace tribus
