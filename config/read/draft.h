#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/schema.h"

/// A configuration while it is read: it may contain mistakes, and it has the places in the file
/// that the checks across tables need for their messages.
namespace tribus {

/// [input.NAME]. The flags `..._sound` are false after a mistake in the keys that they stand for.
struct InputDraft {
    InputConfig config;
    Location where;                   ///< place of its name
    std::optional<Location> timeout;  ///< place of the value, if given
    bool timeout_sound = true;
    bool port_sound = true;
    bool settings_sound = true;
    bool used = false;
};

/// [gpio.NAME], as above, or a line that an output names.
struct LineDraft {
    LineConfig config;
    Location where;                  ///< place of its name
    std::optional<Location> period;  ///< place of the value, if given
    bool period_sound = true;
    bool place_sound = true;
    bool role_sound = true;
};

/// A value that an output sends.
struct ValueUse {
    NamedUse use;
    Location where;
};

/// [output.NAME], as above.
struct OutputDraft {
    OutputConfig config;
    Location where;
    Location period;  ///< place of the value, or of the table
    bool period_sound = true;
    bool port_sound = true;
    bool settings_sound = true;
    std::optional<std::string> pipeline;  ///< name of the pipeline that feeds it
    bool needs_pipeline = true;           ///< false: it sends no channels
    std::vector<ValueUse> used_values;
    std::optional<LineDraft> enable_line{};
};

/// [sensor_bus.NAME], as above.
struct SensorBusDraft {
    SensorBusConfig config;
    Location where;  ///< place of its name
    bool port_sound = true;
};

/// [values.NAME], as above.
struct ValuesDraft {
    ValuesConfig config;
    Location where;  ///< place of its name
    /// False: its source could not be read, so the names of its values are unknown.
    bool sound = true;
};

/// [dronecan.NAME], as above.
struct DroneCanDraft {
    DroneCanConfig config;
    Location where;                   ///< place of its name
    std::optional<Location> node_id;  ///< place of the value, if given
    bool sound = true;
};

/// The whole file.
struct Draft {
    RuntimeConfig runtime;
    std::optional<RecorderConfig> recorder;
    std::vector<InputDraft> inputs;
    std::vector<OutputDraft> outputs;
    std::vector<PipelineConfig> pipelines;
    std::vector<LineDraft> lines;
    std::vector<SensorBusDraft> sensor_buses;
    std::vector<SensorType> sensor_types;
    std::vector<Location> sensor_type_places;  ///< places of their names
    std::vector<ValuesDraft> values;
    std::vector<DroneCanDraft> dronecan;
    /// A pipeline's `from` or `to` could not be read, so it is unknown which ones are used.
    bool inputs_uncertain = false;
    bool outputs_uncertain = false;
    /// A channel of a pipeline could not be read, so it is unknown which lines are used.
    bool channels_uncertain = false;
    /// False: something other than a named table stands there, and an unknown name may be meant by
    /// it.
    bool input_names_known = true;
    bool output_names_known = true;
    bool line_names_known = true;
    bool value_names_known = true;
};

/// Index of the element with that name.
template <class Drafts>
std::optional<std::size_t> index_of(const Drafts& drafts, std::string_view name) {
    for (std::size_t i = 0; i < drafts.size(); ++i) {
        if (drafts[i].config.name == name) {
            return i;
        }
    }
    return std::nullopt;
}

/// Names of all elements.
template <class Drafts>
std::vector<std::string_view> names_in(const Drafts& drafts) {
    std::vector<std::string_view> names(drafts.size());
    std::ranges::transform(drafts, names.begin(),
                           [](const auto& draft) { return std::string_view(draft.config.name); });
    return names;
}

}  // namespace tribus
