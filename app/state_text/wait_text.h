#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/schema/schema.h"
#include "core/time.h"
#include "pipelines/engine/output.h"
#include "pipelines/engine/output_wait.h"

namespace tribus {

/// Names of all inputs, by index, as the functions below want them.
std::vector<std::string> input_names(const Configuration& configuration);

/// Tells what an output waits for, and how far that is: "receiver: good for 0.2 of 0.5 s". Empty if
/// it is in control. `inputs`: names of all inputs, by index.
std::string wait_text(const OutputState& state, const OutputWait& wait,
                      std::span<const std::string> inputs);

/// The state of an output alone: "in failsafe".
std::string stage_text(const OutputState& state, std::span<const std::string> inputs);

/// The state of an output with what it waits for: "in failsafe; waits for receiver: never seen".
std::string output_sentence(const OutputState& state, const OutputWait& wait,
                            std::span<const std::string> inputs);

/// "180 ms", "4.2 s", "3 min 12 s", "2 h 5 min": for a person who looks.
std::string duration_text(Duration duration);

/// Text that differs between any two things that an output may wait for, without how far they are.
/// It has names, not indices: another configuration may number the inputs differently.
std::string wait_key(const OutputWait& wait, std::span<const std::string> inputs);

/// Decides when a change of what an output waits for is told: at once when its state changes, else
/// when it has waited for something else for `kPatience`. A start or a recovery without trouble
/// takes less. Pure; thread-bound.
class WaitWatch {
  public:
    /// Longer than the default of `recover`, and short enough that a teller that looks five times a
    /// second is done within a second.
    static constexpr Duration kPatience = std::chrono::milliseconds(700);

    /// `key`: what it waits for at `now`. Returns the one to be told.
    const std::string& look(const std::string& key, bool state_changed, Instant now);

  private:
    std::string told_;
    std::optional<Instant> differs_since_;
};

}  // namespace tribus
