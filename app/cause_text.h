#pragma once

#include <span>
#include <string>

#include "pipelines/link_supervisor.h"
#include "pipelines/output.h"

namespace tribus {

/// For the log and reports: the cause and how it shows, as "radio lost (the receiver says
/// failsafe)".
std::string cause_text(const LinkState& state);

/// The same of an output: "under control of backup", "in failsafe until it is released".
/// `inputs` are the names of all inputs, by index.
std::string output_text(const OutputState& state, std::span<const std::string> inputs);

}  // namespace tribus
