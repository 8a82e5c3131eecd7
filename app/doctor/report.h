#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/gpio_facts.h"
#include "app/doctor/facts/input_facts.h"
#include "app/doctor/facts/machine_facts.h"
#include "app/doctor/facts/pwm_facts.h"
#include "app/doctor/facts/serial_facts.h"
#include "app/doctor/facts/spi_facts.h"
#include "app/doctor/listening/line_judge.h"
#include "app/doctor/serial_judge.h"
#include "transports/links/can/can_interface.h"

namespace tribus::doctor {

struct ExaminedPort {
    SerialFacts facts{};
    PortOpinion opinion{};
    bool tried = false;  ///< the abilities were tried, not derived from the kind of port
    std::optional<LineStory> story{};
    std::vector<std::string> lines{};  ///< for a configuration
};

struct Report {
    /// Empty if only devices were asked for.
    std::optional<MachineFacts> machine;
    std::vector<ExaminedPort> ports;
    std::vector<CanInterface> can;
    std::vector<InputFacts> inputs;
    std::vector<PwmFacts> pwm;
    /// Empty if only other devices were asked for.
    std::optional<UinputFacts> uinput;
    std::vector<GpioFacts> gpio;
    std::vector<SpiFacts> spi;
    /// Ordered by severity, problems first.
    std::vector<Finding> findings;
};

/// For people, in lines of at most `columns`, except commands and lines to copy.
std::string report_text(const Report& report, std::size_t columns, bool colour);

/// One JSON object; docs/doctor.md describes its fields.
std::string report_json(const Report& report);

}  // namespace tribus::doctor
