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

struct OutputDraft {
    OutputConfig config;
    Location where;
    Location period;  ///< of the value, or of the table
    bool period_sound = true;
    bool port_sound = true;
    bool settings_sound = true;
    std::optional<std::string> pipeline;  ///< the one that feeds it
};

struct Draft {
    RuntimeConfig runtime;
    std::vector<InputDraft> inputs;
    std::vector<OutputDraft> outputs;
    std::vector<PipelineConfig> pipelines;
    /// A pipeline's `from` or `to` could not be read: what is used is not known.
    bool inputs_uncertain = false;
    bool outputs_uncertain = false;
    /// Something stands where only named tables may: a name that is not found may be meant there.
    bool input_names_known = true;
    bool output_names_known = true;
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

}  // namespace tribus
