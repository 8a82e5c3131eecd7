#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/line_settings.h"
#include "core/schedule.h"
#include "core/setting.h"
#include "core/time.h"
#include "pipelines/rules/settings.h"
#include "pipelines/sensor_bus/receiver_role.h"
#include "pipelines/sensor_bus/sensor_role.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dronecan/source.h"
#include "transports/codecs/ibus_sensor/types.h"
#include "transports/codecs/protocol.h"
#include "transports/links/gpio/gpio_place.h"
#include "transports/links/medium.h"

/// The configuration as plain values: a checked file with every default.
namespace tribus {

/// A place in the configuration file. Line and column count from 1.
struct Location {
    unsigned line = 0;
    unsigned column = 0;

    /// Always equal: the place of a thing does not change its meaning.
    friend bool operator==(Location, Location) { return true; }
};

enum class Realtime : std::uint8_t { automatic, off, require };

/// [runtime].
struct RuntimeConfig {
    Realtime realtime = Realtime::automatic;
    int priority = 80;
    std::optional<int> cpu;
    Location cpu_where{};
    /// For this time before a deadline the data thread polls the clock instead of sleeping.
    Duration spin{};

    bool operator==(const RuntimeConfig&) const = default;
};

/// The place that an input or output uses, such as a serial device or a CAN interface.
struct PortConfig {
    const Medium* medium = nullptr;
    std::string device;      ///< the place, by the name that the medium gives it
    LineSettings line;       ///< if the medium has a line
    SettingValues settings;  ///< values of the medium's own keys
    Location where;          ///< place of the value of `device`

    bool operator==(const PortConfig&) const = default;
};

/// [input.NAME].
struct InputConfig {
    std::string name;
    const Protocol* protocol = nullptr;
    SettingValues settings;  ///< values of the protocol's own keys
    PortConfig port;
    SupervisionSettings supervision;
    std::vector<ChannelRule> channels;       ///< map of the input itself, before any pipeline
    std::vector<Location> channels_where{};  ///< place of each source

    bool operator==(const InputConfig&) const = default;
};

/// Reaction of an output on CAN to another node that sends frames with the same ids.
enum class ForeignSender : std::uint8_t { failsafe, ignore };

/// Default upper limit of the period of an output. A protocol may set its own.
inline constexpr Duration kMostOutputPeriod = std::chrono::seconds(1);

/// [output.NAME].
struct OutputConfig {
    std::string name;
    const Protocol* protocol = nullptr;
    SettingValues settings;
    PortConfig port;
    ScheduleSettings schedule;
    bool force = false;
    ForeignSender foreign_sender = ForeignSender::failsafe;

    bool operator==(const OutputConfig&) const = default;
};

/// The time of the longest frame on the wire and a pause of one byte. Zero without a line.
inline Duration frame_time(const OutputConfig& output) {
    const Protocol& protocol = *output.protocol;
    const std::size_t more =
        protocol.longer_by != nullptr ? protocol.longer_by(output.settings) : 0;
    return output.port.medium->has_line
               ? output.port.line.bytes_time(protocol.longest_frame + more + 1)
               : Duration::zero();
}

/// Whether answers of the receiver of its frames tell what is wrong with them.
inline bool hears_answers(const OutputConfig& output) {
    return output.protocol->advice_by_answers != nullptr;
}

/// Whether the receiver of its frames sets their timing.
inline bool is_timed_by_receiver(const OutputConfig& output) {
    return output.protocol->is_timed_by_receiver != nullptr &&
           output.protocol->is_timed_by_receiver(output.settings);
}

/// The link of an input or output whose messages are proved by a key. Nothing for others.
template <class Part>
std::optional<LinkWithKey> link_with_key(const Part& part) {
    return part.protocol->link_with_key != nullptr ? part.protocol->link_with_key(part.settings)
                                                   : std::nullopt;
}

/// Whether its messages are proved by a key, and their receiver answers.
template <class Part>
bool is_answered(const Part& part) {
    const auto link = link_with_key(part);
    return link && !link->epoch;
}

template <class Part>
KeyUse key_use(const Part& part) {
    return link_with_key(part)                       ? KeyUse::given
           : part.protocol->link_with_key != nullptr ? KeyUse::possible
                                                     : KeyUse::impossible;
}

/// [pipeline.NAME].
struct PipelineConfig {
    std::string name;
    SelectionSettings selection;
    std::vector<std::size_t> outputs;  ///< indices
    std::vector<ChannelRule> channels;
    std::vector<Location> channels_where{};  ///< place of each source
    std::vector<FailsafeSettings> failsafe;  ///< one for each of `outputs`

    bool operator==(const PipelineConfig&) const = default;
};

/// A GPIO line and its task.
struct LineConfig {
    std::string name;
    /// No table of its own names it, but the key `output_enable` of its output.
    bool of_output = false;
    GpioPlace place;
    Location where;  ///< place of the value of `line`
    bool active_low = false;
    GpioBias bias = GpioBias::as_is;
    LineTask task;

    bool operator==(const LineConfig&) const = default;
};

/// One sensor whose role the program plays.
struct SensorConfig {
    SensorType type;
    /// Name of the value for each field of the type. Empty: none.
    std::vector<std::string> values;
    /// Places of these names in the file.
    std::vector<Location> where;
    /// Absent: the units of value and field determine it.
    std::optional<double> scale;
    double offset = 0;
    std::optional<double> not_available;

    bool operator==(const SensorConfig&) const = default;
};

enum class BusRole : std::uint8_t { sensor, receiver };

/// [sensor_bus.NAME].
struct SensorBusConfig {
    std::string name;
    PortConfig port;
    BusRole role = BusRole::sensor;
    Wires wires = Wires::automatic;
    SensorDialect dialect = SensorDialect::flysky;

    std::vector<SensorConfig> sensors;
    std::uint8_t address = 1;
    bool chain = false;
    Duration reply_after = kUsualReplyAfter;
    Duration reply_within = kUsualReplyWithin;

    Duration slot = kUsualSlot;
    bool power_up = true;
    int probe_every = kUsualProbeEvery;
    int drop_after = kUsualDropAfter;
    Duration timeout = std::chrono::seconds(2);

    bool operator==(const SensorBusConfig&) const = default;
};

/// A constant value.
struct ConstantConfig {
    double number = 0;
    std::string unit;

    bool operator==(const ConstantConfig&) const = default;
};

/// Values from a message that a DBC file describes.
struct DbcValueSource {
    SettingFile dbc;
    std::string message;
    DbcFile described;  ///< only that message

    bool operator==(const DbcValueSource& other) const {
        return dbc == other.dbc && message == other.message;
    }
};

/// Values from a DroneCAN message, one of dronecan::kValueMessages.
struct DroneCanValueSource {
    std::string message;
    dronecan::SourceChoice from;
    bool fd = false;

    bool operator==(const DroneCanValueSource&) const = default;
};

/// Values from the messages of a protocol on bytes, one of kValueProtocols.
struct ByteValueSource {
    std::string protocol;
    std::optional<KeyFile> key{};

    bool operator==(const ByteValueSource&) const = default;
};

/// One kind of message with values on CAN, or all messages of a protocol on bytes.
struct ValueMessageConfig {
    PortConfig port;
    std::variant<DbcValueSource, DroneCanValueSource, ByteValueSource> layout;
    Duration timeout{};
    /// Own names of values (first), and their names in the message (second).
    std::vector<std::pair<std::string, std::string>> names;

    bool operator==(const ValueMessageConfig&) const = default;
};

/// [values.NAME].
struct ValuesConfig {
    std::string name;
    std::variant<ConstantConfig, ValueMessageConfig> source;

    bool operator==(const ValuesConfig&) const = default;
};

/// [dronecan.NAME]: this program as a DroneCAN node.
struct DroneCanConfig {
    std::string name;
    PortConfig port;
    /// With `dynamic`: the preferred id. Absent: any, or that of an output.
    std::optional<std::uint8_t> node_id;
    bool dynamic = false;
    std::string node_name = "org.tribus";
    bool allow_restart = false;
    bool allow_writes = false;

    bool operator==(const DroneCanConfig&) const = default;
};

/// [recorder]: keeps in memory what passed the ports, and writes it to a folder on an event.
struct RecorderConfig {
    std::string directory;                       ///< empty: given by the service manager
    Location where;                              ///< place of the table
    int memory_kib = 1024;                       ///< for each port
    Duration before = std::chrono::seconds(30);  ///< time before the event
    Duration after = std::chrono::seconds(2);    ///< time after the event
    bool on_failsafe = true;
    /// Least time between two recordings that were not requested.
    Duration pause = std::chrono::seconds(60);
    int keep = 20;        ///< number of recordings
    int space_mib = 100;  ///< size of all recordings

    bool operator==(const RecorderConfig&) const = default;
};

/// What a configuration may say, but probably does not mean.
struct Warning {
    Location where;
    std::string text;  ///< "what is doubtful; what to do", one line
};

/// A whole configuration.
struct Configuration {
    std::string file;
    std::vector<Warning> warnings;
    RuntimeConfig runtime;
    /// Absent: nothing is recorded.
    std::optional<RecorderConfig> recorder;
    std::vector<InputConfig> inputs;
    std::vector<OutputConfig> outputs;
    std::vector<PipelineConfig> pipelines;
    std::vector<LineConfig> lines;
    std::vector<SensorBusConfig> sensor_buses;
    std::vector<SensorType> sensor_types;
    std::vector<ValuesConfig> values;
    std::vector<DroneCanConfig> dronecan;
};

}  // namespace tribus
