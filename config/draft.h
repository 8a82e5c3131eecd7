#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema.h"

/// A configuration while it is read: perhaps with mistakes, and with the places that the checks
/// across tables name in their messages.
namespace tribus {

struct InputDraft {
    InputConfig config;
    Location where;                   ///< of its name
    std::optional<Location> timeout;  ///< of the value, where it is given
    bool timeout_sound = true;
    bool port_sound = true;
    bool settings_sound = true;
    bool used = false;
};

/// A named value that an output sends.
struct ValueUse {
    std::string name;
    Location where;
};

struct OutputDraft {
    OutputConfig config;
    Location where;
    Location period;  ///< of the value, or of the table
    bool period_sound = true;
    bool port_sound = true;
    bool settings_sound = true;
    std::optional<std::string> pipeline;  ///< the one that feeds it
    bool needs_pipeline = true;           ///< false: it carries no channels
    std::vector<ValueUse> used_values;
};

struct LineDraft {
    LineConfig config;
    Location where;                  ///< of its name
    std::optional<Location> period;  ///< of the value, where it is given
    bool period_sound = true;
    bool place_sound = true;
    bool role_sound = true;
};

struct SensorBusDraft {
    SensorBusConfig config;
    Location where;  ///< of its name
    bool port_sound = true;
};

struct ValuesDraft {
    ValuesConfig config;
    Location where;  ///< of its name
    /// Its source could not be read: what names it has is not known.
    bool sound = true;
};

struct DroneCanDraft {
    DroneCanConfig config;
    Location where;                   ///< of its name
    std::optional<Location> node_id;  ///< of the value, where it is given
    bool sound = true;
};

struct Draft {
    RuntimeConfig runtime;
    std::optional<RecorderConfig> recorder;
    std::vector<InputDraft> inputs;
    std::vector<OutputDraft> outputs;
    std::vector<PipelineConfig> pipelines;
    std::vector<LineDraft> lines;
    std::vector<SensorBusDraft> sensor_buses;
    std::vector<SensorType> sensor_types;
    std::vector<Location> sensor_type_places;  ///< of their names
    std::vector<ValuesDraft> values;
    std::vector<DroneCanDraft> dronecan;
    /// A pipeline's `from` or `to` could not be read: what is used is not known.
    bool inputs_uncertain = false;
    bool outputs_uncertain = false;
    /// A channel of a pipeline could not be read: which lines are used is not known.
    bool channels_uncertain = false;
    /// Something stands where only named tables may: a name that is not found may be meant there.
    bool input_names_known = true;
    bool output_names_known = true;
    bool line_names_known = true;
    bool value_names_known = true;
};

/// The index of the element of that name.
template <class Drafts>
std::optional<std::size_t> index_of(const Drafts& drafts, std::string_view name) {
    for (std::size_t i = 0; i < drafts.size(); ++i) {
        if (drafts[i].config.name == name) {
            return i;
        }
    }
    return std::nullopt;
}

template <class Drafts>
std::vector<std::string_view> names_in(const Drafts& drafts) {
    std::vector<std::string_view> names;
    names.reserve(drafts.size());
    for (const auto& draft : drafts) {
        names.emplace_back(draft.config.name);
    }
    return names;
}

}  // namespace tribus
