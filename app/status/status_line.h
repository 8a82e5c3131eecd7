#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/time.h"
#include "pipelines/realtime/loop.h"

namespace tribus {

/// The state of all inputs and outputs in one line for a service manager: "servos: in failsafe;
/// receiver: wire silent (no bytes any more)". The worst state comes first. Pure; thread-bound.
class StatusLine {
  public:
    StatusLine(std::vector<std::string> inputs, std::vector<std::string> outputs);

    /// Both lists are in the order of the names. Durations of a failsafe or loss are rounded down
    /// to steps, so that they do not change the line all the time.
    std::string text(std::span<const InputStatus> inputs, std::span<const OutputStatus> outputs,
                     Instant now);

  private:
    struct Since {
        std::optional<OutputStage> stage;
        Instant at{};
    };

    std::string said_of(const OutputStatus& output, Instant now, Instant since) const;

    std::vector<std::string> input_names_;
    std::vector<std::string> output_names_;
    std::vector<Since> since_;
};

}  // namespace tribus
