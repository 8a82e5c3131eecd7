#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/time.h"
#include "pipelines/engine/engine.h"
#include "pipelines/rules/link_supervisor.h"

namespace tribus {

/// Prints what changes in a simulated engine, with the time: causes of inputs, states of outputs.
class SimulateLog {
  public:
    explicit SimulateLog(const Engine& engine);
    /// Prints each change since the last call to standard error.
    void look(Instant now);

  private:
    const Engine& engine_;
    std::vector<std::string> input_names_;
    std::vector<LinkCause> causes_;
    std::vector<bool> two_senders_printed_;
    /// The latest states, and their texts.
    std::vector<OutputState> states_;
    std::vector<std::string> outputs_;
    std::vector<std::uint32_t> presets_printed_;
};

}  // namespace tribus
