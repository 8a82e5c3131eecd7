#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/init/attachment.h"

namespace tribus::init {

/// Below a throttle stick of 1000 to 2000 us, and the low end of the usual scale of SBUS.
inline constexpr double kLowThrottleUs = 988;

/// The content of a configuration: one pipeline from the inputs to the outputs.
struct Plan {
    std::vector<Attachment> inputs;   ///< at least one; the first healthy one has control
    std::vector<Attachment> outputs;  ///< at least one
    double throttle_us = kLowThrottleUs;
};

/// Names of the tables, in order: "receiver", "receiver2", "bus"; "servos", "bus".
std::vector<std::string> input_names(const Plan& plan);
std::vector<std::string> output_names(const Plan& plan);

/// Whether any output sends presets in failsafe. The others fall silent.
bool sends_presets(const Plan& plan);

/// Text of the configuration, with comments that name its file. Pure.
std::string configuration_text(const Plan& plan, std::string_view file_name);

}  // namespace tribus::init
