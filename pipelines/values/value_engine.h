#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/engine/carry_over.h"
#include "pipelines/engine/engine.h"
#include "pipelines/engine/health_watch.h"
#include "pipelines/sensor_bus/receiver_role.h"
#include "pipelines/sensor_bus/sensor_role.h"
#include "transports/codecs/can_value_reader.h"
#include "transports/codecs/frame_encoder.h"
#include "transports/codecs/undamaged_parts.h"

namespace tribus {

using SensorBusSettings = std::variant<SensorRoleSettings, ReceiverRoleSettings>;

/// Messages with named values, on CAN or on bytes.
struct ValueMessageSettings {
    AnyValueReader reader;
    /// Index on the board for each value of the reader. `nullopt`: no name refers to it.
    std::vector<std::optional<std::size_t>> values;
};

/// A named value that is a fact about an input or output.
struct HealthValue {
    std::size_t value = 0;
    std::size_t index = 0;  ///< index of the input or output
    std::variant<InputFact, OutputFact> fact;
};

/// A named value that is a channel, in microseconds: of an input as received, of an output as last
/// sent. Unavailable while the input is lost or the output is silent.
struct ChannelValue {
    std::size_t value = 0;
    bool of_output = false;
    std::size_t index = 0;  ///< index of the input or output
    std::size_t channel = 0;
};

/// A named value that does not change.
struct ConstantValue {
    std::size_t value = 0;
    double number = 0;
};

struct ValueEngineSettings {
    std::vector<NamedValue> values;
    std::vector<SensorBusSettings> buses;
    std::vector<ValueMessageSettings> messages;
    std::vector<HealthValue> health;
    std::vector<ChannelValue> channels;
    std::vector<ConstantValue> constants;
    /// Indices on the board for the facts of the machine, in the order of kMachineFacts.
    std::vector<std::size_t> machine;
};

/// State of a sensor bus, for status and log.
struct SensorBusState {
    bool is_receiver = false;
    SensorRoleCounts sensor;      ///< if it has the sensor role
    ReceiverRoleCounts receiver;  ///< if it has the receiver role
    EchoCounts echo;
    /// Sensor role: address of its first sensor. 0 while it waits for one.
    std::uint8_t first_address = 0;
    /// When the latest request came. Absent before the first one and after a loss of the device.
    std::optional<Instant> latest_request;
    std::array<FoundSensor, kMostSensors> found{};
    std::size_t found_count = 0;
    /// Receiver role: what is wrong with sensors that answer.
    SensorFaults faults{};
};

/// All named values of a configuration and their sources: sensor buses in both roles, CAN messages,
/// facts about inputs, outputs and the machine, constants. Makes no system call and does not
/// allocate after construction. The caller passes what was read, calls `poll` and writes what the
/// buses have to send. Thread-bound.
class ValueEngine {
  public:
    explicit ValueEngine(ValueEngineSettings settings);

    const ValueBoard& board() const { return board_; }
    std::size_t bus_count() const { return buses_.size(); }

    /// Sets the constants and starts the buses.
    void start(Instant now);
    /// Call after `start`. The parts named in `carry` and `engine` take over their state in
    /// `before`, which is unusable afterwards.
    void continue_from(ValueEngine& before, const ValueCarry& carry, const EngineCarry& engine);

    /// Takes undamaged bytes of one bus, read at `now`.
    void receive(std::size_t bus, std::span<const std::uint8_t> bytes, Instant now) {
        role(bus).receive(bytes, now, board_);
    }
    /// The same for bytes with damage. `damaged[i]` is true if byte i was damaged on the line.
    template <class DamagedMarks>
    void receive(std::size_t bus, std::span<const std::uint8_t> bytes, const DamagedMarks& damaged,
                 Instant now) {
        for_undamaged_parts(
            bytes, damaged,
            [&](std::span<const std::uint8_t> part) { role(bus).receive(part, now, board_); },
            [&] { role(bus).damaged_byte(now); });
    }
    /// Takes a CAN frame that arrived at `at` on the interface of one message.
    void receive(std::size_t message, const CanFrame& frame, Instant at);
    /// Takes undamaged bytes of one message's port, read at `now`.
    void receive_message(std::size_t message, std::span<const std::uint8_t> bytes, Instant now);
    /// The same for bytes with damage, as above.
    template <class DamagedMarks>
    void receive_message(std::size_t message, std::span<const std::uint8_t> bytes,
                         const DamagedMarks& damaged, Instant now) {
        for_undamaged_parts(
            bytes, damaged,
            [&](std::span<const std::uint8_t> part) { receive_message(message, part, now); },
            [&] { message_damaged(message); });
    }
    /// A byte of one message's port was damaged, or bytes were discarded.
    void message_damaged(std::size_t message);
    /// The device of one message is gone.
    void message_lost(std::size_t message);
    /// The device of one bus is gone.
    void device_lost(std::size_t bus) { role(bus).device_lost(board_); }
    /// Unread bytes of one bus were discarded.
    void bytes_discarded(std::size_t bus, Instant now) { role(bus).damaged_byte(now); }
    /// Sets a fact of the machine, measured at `at`. `nullopt`: the machine does not report it.
    void set_machine(std::size_t index, std::optional<double> number, Instant at);

    /// Does all that is due at `now`. Returns the time of the next call at the latest. Call it
    /// after `receive` too.
    Instant poll(const Engine& engine, Instant now);

    /// Indices of the buses that have something to send after the last `poll`, at once.
    std::span<const std::size_t> ran() const { return ran_; }
    /// Takes what one of them sends. Valid until the next `poll`.
    Transmission take(std::size_t bus) { return std::exchange(transmissions_[bus], {}); }
    /// The caller handed over what it took from a bus, or could not send it.
    void written(std::size_t bus, Instant now) { role(bus).written(now, board_); }
    void dropped(std::size_t bus) { role(bus).dropped(); }

    SensorBusState bus_state(std::size_t bus) const;
    /// The CAN ids of one message; none on bytes.
    std::span<const CanIdMatch> wanted_ids(std::size_t message) const;
    bool on_can(std::size_t message) const { return can_reader(message) != nullptr; }
    bool uses_fd(std::size_t message) const;

  private:
    /// Null if the message is not of that kind.
    CanValueReader* can_reader(std::size_t message) const;
    ByteValueReader* byte_reader(std::size_t message) const;
    void note_readings(const ValueMessageSettings& source, Instant at);
    SensorBusRole& role(std::size_t bus) { return *roles_[bus]; }
    void make_health_watch();
    void update_health(const Engine& engine, Instant now);
    void update_channels(const Engine& engine, Instant now);

    ValueBoard board_;
    std::vector<std::variant<std::unique_ptr<SensorRole>, std::unique_ptr<ReceiverRole>>> buses_;
    std::vector<SensorBusRole*> roles_;
    std::vector<ValueMessageSettings> messages_;
    std::vector<ValueReading> readings_;
    std::vector<HealthValue> health_;
    std::vector<ChannelValue> channels_;
    std::vector<std::size_t> machine_;
    std::vector<ConstantValue> constants_;
    std::optional<HealthWatch> health_watch_;
    Instant next_health_ = kNever;
    std::vector<std::size_t> ran_;
    std::vector<Transmission> transmissions_;  ///< one for each bus
};

}  // namespace tribus
