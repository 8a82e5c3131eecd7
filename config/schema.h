#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/line_settings.h"
#include "core/schedule.h"
#include "core/setting.h"
#include "core/time.h"
#include "pipelines/settings.h"
#include "transports/codecs/protocol.h"

/// The configuration as plain values: what a checked file means, with every default filled in.
namespace tribus {

/// A place in the configuration file, both counted from 1.
struct Location {
    unsigned line = 0;
    unsigned column = 0;
};

enum class Realtime : std::uint8_t { automatic, off, require };

struct RuntimeConfig {
    Realtime realtime = Realtime::automatic;
    int priority = 80;
    std::optional<int> cpu;
    /// So long before a deadline the data thread stays awake for it.
    Duration spin{};
};

/// The serial device or CAN interface that an input or output uses.
struct PortConfig {
    LinkKind link = LinkKind::serial;
    std::string device;  ///< path of a device, or name of an interface
    LineSettings line;   ///< serial only
    Location where;      ///< of the value of `device` or `interface`
};

struct InputConfig {
    std::string name;
    const Protocol* protocol = nullptr;
    SettingValues settings;  ///< the protocol's own keys
    PortConfig port;
    Duration timeout{};
    std::vector<LossRule> failsafe_when;
};

struct OutputConfig {
    std::string name;
    const Protocol* protocol = nullptr;
    SettingValues settings;
    PortConfig port;
    ScheduleSettings schedule;
    bool force = false;
    bool yield_to_foreign_sender = true;
};

struct PipelineConfig {
    std::string name;
    std::vector<std::size_t> inputs;   ///< indices, the preferred first
    std::vector<std::size_t> outputs;  ///< indices
    std::vector<ChannelRule> channels;
    std::vector<FailsafeSettings> failsafe;  ///< one for each of `outputs`
};

struct Configuration {
    std::string file;
    RuntimeConfig runtime;
    std::vector<InputConfig> inputs;
    std::vector<OutputConfig> outputs;
    std::vector<PipelineConfig> pipelines;
};

}  // namespace tribus
