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
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/codecs/ibus_sensor/types.h"

namespace tribus {

/// Indices on the board for the reading of one address: the raw value and the first fields.
struct ReadingPlaces {
    std::size_t raw = 0;
    std::vector<std::size_t> fields;
};

/// Indices on the board for the reading of the first sensor of a type, in addition.
struct TypePlaces {
    std::uint8_t type = 0;
    std::vector<std::size_t> fields;
};

/// `automatic`: one wire if the power-up frames, which no sensor answers, come back.
enum class Wires : std::uint8_t { automatic, one, two };

/// Usual settings. The slot is that of genuine receivers (docs/protocols/ibus.md, "Sensor bus:
/// timing").
inline constexpr Duration kUsualSlot = std::chrono::microseconds(7700);
inline constexpr int kUsualProbeEvery = 66;
inline constexpr int kUsualDropAfter = 66;

struct ReceiverRoleSettings {
    /// Duration of a slot, in which one request is sent.
    Duration slot = kUsualSlot;
    Wires wires = Wires::automatic;
    /// Sends power-up frames first, as genuine receivers do. Without them `automatic` means one
    /// wire.
    bool power_up_frames = true;
    /// Number of slots between two searches for a further sensor.
    int probe_every = kUsualProbeEvery;
    /// A sensor that leaves this number of requests in a row unanswered is gone, and so are those
    /// behind it.
    int drop_after = kUsualDropAfter;
    SensorTypes types = SensorTypes();
    std::array<ReadingPlaces, kMostSensors> readings{};
    std::vector<TypePlaces> first_of_type{};
};

/// Type and size of a value, as the sensor reports them.
struct FoundSensor {
    std::uint8_t type = 0;
    std::uint8_t size = 0;

    bool operator==(const FoundSensor&) const = default;
};

/// Whether a value of this size can be read as one of the type: another size than that of the table
/// only if both are usual ones.
bool is_readable(const SensorType& type, std::uint8_t size);

/// What is wrong with a sensor that answers.
struct SensorFault {
    enum class Kind : std::uint8_t {
        none,
        /// It answers whether it is there, but not which type it has. Nothing of it is read, and no
        /// sensor behind it is looked for.
        no_type,
        /// Its values have another size than it reported with its type. They are not read.
        wrong_size,
    };
    Kind kind = Kind::none;
    std::uint8_t sent_size = 0;  ///< of its latest value, if that is wrong

    bool operator==(const SensorFault&) const = default;
};

/// Faults by address; the first one is that of address 1.
using SensorFaults = std::array<SensorFault, kMostSensors>;

/// Counters since the start. They never decrease.
struct ReceiverRoleCounts {
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
    std::uint64_t misses = 0;  ///< type and value requests without an answer
    std::uint64_t wrong = 0;   ///< answers to another request, or of another size
    std::uint64_t lost_sensors = 0;
    std::uint64_t dropped = 0;  ///< requests that the port did not take
};

/// The program in the role of the receiver: finds sensors, polls them in turn and sets the named
/// values (docs/protocols/ibus.md, "Sensor bus: timing" and "Sensor bus: the role of a receiver").
class ReceiverRole final : public SensorBusRole {
  public:
    explicit ReceiverRole(ReceiverRoleSettings settings);

    void start(Instant now) override;
    /// Takes over the state of `before`, a role with the same settings except the indices on the
    /// board.
    void continue_from(const ReceiverRole& before);
    void receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) override;
    void damaged_byte(Instant now) override;
    Instant due() const override { return ongoing_.next_slot; }
    std::span<const std::uint8_t> run(Instant now, ValueBoard& board) override;
    void written(Instant now, ValueBoard& board) override;
    void dropped() override;
    void device_lost(ValueBoard& board) override;

    /// The sensors that answer, from address 1 on.
    std::span<const FoundSensor> found() const { return {found_.data(), found_count_}; }
    const SensorFaults& faults() const { return ongoing_.faults; }
    const ReceiverRoleCounts& counts() const { return ongoing_.counts; }
    const EchoCounts& echo() const { return ongoing_.echo.counts(); }
    const SensorFrameParser& parser() const { return ongoing_.parser; }

  private:
    enum class Stage : std::uint8_t { power_up, silence, polling };

    struct Request {
        SensorCommand command = SensorCommand::discover;
        std::uint8_t address = 1;

        bool operator==(const Request&) const = default;
    };
    /// A sensor that answers, and how to decode its value.
    struct Sensor {
        /// Null if the table has no such type or size.
        const SensorType* type = nullptr;
        /// Null if it is not the first of its type, or if no named value refers to the type.
        const TypePlaces* by_type = nullptr;
        int misses = 0;
    };

    /// A reload keeps this state, besides the sensors that were found.
    struct Ongoing {
        SensorFrameParser parser{};
        EchoCanceller echo{};
        Stage stage = Stage::power_up;
        int slots_in_stage = 0;
        Instant next_slot = kNever;
        /// The request of the present slot. Empty once it was answered.
        std::optional<Request> open{};
        /// Request of the next slot, if it must follow at once.
        std::optional<Request> follow_up{};
        bool repeated = false;
        std::size_t next_polled = 0;
        int slots_since_probe = 0;
        std::array<std::uint8_t, kLongestSensorFrame> wire{};
        std::size_t wire_length = 0;
        SensorFaults faults{};
        ReceiverRoleCounts counts{};
    };

    SensorFault& fault_of(std::uint8_t address) { return ongoing_.faults[address - 1U]; }
    void conclude(ValueBoard& board);
    void type_missed(const Request& request);
    void value_missed(std::uint8_t address, ValueBoard& board);
    std::optional<Request> next_request();
    Request next_poll();
    std::span<const std::uint8_t> send(const Request& request);
    void take(const SensorFrame& frame, Instant now, ValueBoard& board);
    std::size_t size_due(const SensorFrame& frame) const;
    void refuse(const SensorFrame& frame);
    void take_type(const SensorFrame& frame, ValueBoard& board);
    void add_sensor(const FoundSensor& found);
    const SensorType* type_of(const FoundSensor& found) const;
    const TypePlaces* places_of_first(std::uint8_t type) const;
    void read_value(std::size_t sensor, std::span<const std::uint8_t> data, Instant now,
                    ValueBoard& board);
    void drop_from(std::size_t sensor, ValueBoard& board);
    void forget_reading(std::size_t sensor, ValueBoard& board);
    bool receives_echo() const;

    ReceiverRoleSettings settings_;
    /// By id. The table's own search runs at the start only.
    std::array<const SensorType*, 256> types_by_id_{};
    /// Types of the table with the other usual size, for sensors that report that one.
    std::vector<SensorType> resized_;
    Ongoing ongoing_;
    std::array<FoundSensor, kMostSensors> found_{};
    std::array<Sensor, kMostSensors> sensors_{};
    std::size_t found_count_ = 0;
};

}  // namespace tribus
