#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/state_text/cause_text.h"
#include "app/state_text/wait_text.h"
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
    struct OutputMemory {
        std::optional<OutputState> state;
        WaitWatch awaited{};
        /// What was printed.
        std::string text = output_text({}, {});
        std::string awaited_printed{};
    };

    void look_at_input(std::size_t index, Instant now);
    void look_at_output(std::size_t index, Instant now);

    std::vector<OutputMemory> outputs_;
    std::vector<std::uint32_t> presets_printed_;
};

}  // namespace tribus
