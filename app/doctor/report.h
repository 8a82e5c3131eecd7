#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/doctor/finding.h"
#include "app/doctor/line_judge.h"
#include "app/doctor/machine_facts.h"
#include "app/doctor/serial_facts.h"
#include "app/doctor/serial_judge.h"
#include "transports/links/can_interface.h"

namespace tribus::doctor {

struct ExaminedPort {
    SerialFacts facts{};
    PortOpinion opinion{};
    bool tried = false;  ///< what it can do is what it did
    std::optional<LineStory> story{};
    std::vector<std::string> lines{};  ///< of a configuration
};

struct Report {
    /// Absent where only devices were asked for.
    std::optional<MachineFacts> machine;
    std::vector<ExaminedPort> ports;
    std::vector<CanInterface> can;
    /// The gravest first.
    std::vector<Finding> findings;
};

/// For a person, in lines of at most `columns`, but for commands and lines to be copied.
std::string report_text(const Report& report, std::size_t columns, bool colour);

/// One object; its fields stand in docs/doctor.md.
std::string report_json(const Report& report);

}  // namespace tribus::doctor
