#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/time.h"
#include "pipelines/link_supervisor.h"
#include "pipelines/output.h"

namespace tribus {

/// What goes on, in one line for a service manager: "servos: in failsafe; receiver: wire silent (no
/// bytes any more)", the worst first. Pure; thread-bound.
class StatusLine {
  public:
    StatusLine(std::vector<std::string> inputs, std::vector<std::string> outputs);

    /// In the order of the names. How long a failsafe or a loss lasts is told in steps, so that the
    /// line does not change all the time.
    std::string text(std::span<const LinkState> inputs, std::span<const OutputState> outputs,
                     Instant now);

  private:
    struct Since {
        std::optional<OutputStage> stage;
        Instant at{};
    };

    std::vector<std::string> input_names_;
    std::vector<std::string> output_names_;
    std::vector<Since> since_;
};

}  // namespace tribus
