#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "app/appliance.h"
#include "app/can_report.h"
#include "core/rate_limit.h"
#include "core/time.h"

namespace tribus {

/// Says what changed, and nothing while nothing does. Thread-bound to the main thread.
class StateLog {
  public:
    StateLog(const Appliance& appliance, Instant start);

    /// Compares with the last look and logs each change, at most a few lines a while for each
    /// input, output and device.
    void look(Appliance& appliance, Instant now);

  private:
    struct InputMemory {
        bool on_can = false;
        bool alive = false;
        bool silence_said = false;
        RateLimit limit;
    };
    struct OutputMemory {
        OutputStage stage = OutputStage::failsafe;
        std::uint64_t busy_drops = 0;
        std::uint64_t foreign_frames = 0;
        RateLimit limit;
    };

    void look_at_input(const std::string& name, const InputStatus& status, InputMemory& memory,
                       Instant now);
    void look_at_output(const std::string& name, const OutputStatus& status, OutputMemory& memory,
                        Instant now);

    void look_at_drops(const std::string& name, const OutputStatus& status, OutputMemory& memory,
                       Instant now);
    void say_never_good(const std::string& name, const InputStatus& status, InputMemory& memory,
                        Instant now);

    Instant start_;
    std::vector<InputMemory> inputs_;
    std::vector<OutputMemory> outputs_;
    std::map<std::string, RateLimit> devices_;
    CanReport can_;
};

}  // namespace tribus
