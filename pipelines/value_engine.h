#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/carry_over.h"
#include "pipelines/engine.h"
#include "pipelines/health_watch.h"
#include "pipelines/sensor_bus/receiver_role.h"
#include "pipelines/sensor_bus/sensor_role.h"
#include "transports/codecs/can_value_reader.h"

namespace tribus {

using SensorBusSettings = std::variant<SensorRoleSettings, ReceiverRoleSettings>;

/// A message of a CAN bus with values.
struct ValueMessageSettings {
    std::unique_ptr<CanValueReader> reader;
    /// For each value of the message its place on the board; nothing: nobody may ask for it.
    std::vector<std::optional<std::size_t>> values;
};

/// A value that is the health of an input or output.
struct HealthValue {
    std::size_t value = 0;
    std::size_t index = 0;  ///< of the input or output
    std::variant<InputFact, OutputFact> fact;
};

/// A value that is a channel of an input, as it comes, or of an output, as it was sent last, in
/// microseconds. Of an input that is lost it is none.
struct ChannelValue {
    std::size_t value = 0;
    bool of_output = false;
    std::size_t index = 0;  ///< of the input or output
    std::size_t channel = 0;
};

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
    /// Where the numbers of the machine go, in the order in which they are told.
    std::vector<std::size_t> machine;
};

/// What is known of a sensor bus, for those who tell people.
struct SensorBusState {
    bool is_receiver = false;
    SensorRoleCounts sensor;      ///< of the sensor role
    ReceiverRoleCounts receiver;  ///< of the receiver role
    EchoCounts echo;
    /// Sensor role: of its first sensor, 0 while it waits for one.
    std::uint8_t first_address = 0;
    /// When the latest request was heard; none before the first, and since its device was lost.
    std::optional<Instant> latest_request;
    std::array<FoundSensor, kMostSensors> found{};
    std::size_t found_count = 0;
};

/// All named values of a configuration and where they come from: sensor buses in both roles, CAN
/// messages, the health of inputs and outputs, the machine, constants. Makes no system call and no
/// allocation after construction; whoever drives it brings what was read, calls `poll` and carries
/// away what the buses have to say. Thread-bound.
class ValueEngine {
  public:
    explicit ValueEngine(ValueEngineSettings settings);

    const ValueBoard& board() const { return board_; }
    std::size_t bus_count() const { return buses_.size(); }

    void start(Instant now);
    /// After `start`: what the carries name goes on as it was in `before`, which is left without
    /// use.
    void continue_from(ValueEngine& before, const ValueCarry& carry, const EngineCarry& engine);

    /// Bytes of one bus, read at `now`. `damaged` answers [position] with whether the line damaged
    /// that byte.
    template <class DamagedMarks>
    void receive(std::size_t bus, std::span<const std::uint8_t> bytes, const DamagedMarks& damaged,
                 Instant now) {
        std::size_t start = 0;
        for (std::size_t position = 0; position < bytes.size(); ++position) {
            if (damaged[position]) {
                role(bus).receive(bytes.subspan(start, position - start), now, board_);
                role(bus).damaged_byte(now);
                start = position + 1;
            }
        }
        role(bus).receive(bytes.subspan(start), now, board_);
    }
    /// A CAN frame on the interface of one message.
    void receive(std::size_t message, const CanFrame& frame, Instant at);
    void device_lost(std::size_t bus) { role(bus).device_lost(board_); }
    /// Bytes of one bus were thrown away unread.
    void bytes_discarded(std::size_t bus, Instant now) { role(bus).damaged_byte(now); }
    /// What the machine told of itself at `at`; nothing: it does not tell.
    void set_machine(std::size_t index, std::optional<double> number, Instant at);

    /// Does all that is due at `now`; returns when to call next at the latest. Call it after
    /// `receive` too.
    Instant poll(const Engine& engine, Instant now);

    /// What a bus has to say, to be written at once.
    struct Speech {
        std::size_t bus = 0;
        std::span<const std::uint8_t> bytes;
    };
    /// Of the last `poll`.
    std::span<const Speech> speeches() const { return speeches_; }
    void written(std::size_t bus, Instant now) { role(bus).written(now, board_); }
    void dropped(std::size_t bus) { role(bus).dropped(); }

    SensorBusState bus_state(std::size_t bus) const;
    std::span<const CanIdMatch> wanted_ids(std::size_t message) const {
        return messages_[message].reader->wanted();
    }
    bool uses_fd(std::size_t message) const { return messages_[message].reader->uses_fd(); }

  private:
    SensorBusRole& role(std::size_t bus) { return *roles_[bus]; }
    void make_health_watch();
    void tell_health(const Engine& engine, Instant now);
    void tell_channels(const Engine& engine, Instant now);

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
    std::vector<Speech> speeches_;
};

}  // namespace tribus
