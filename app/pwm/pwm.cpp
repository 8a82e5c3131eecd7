#include "app/pwm/pwm.h"

#include <fmt/format.h>

#include <memory>
#include <vector>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "app/pwm/pwm_text.h"
#include "transports/codecs/pwm/pwm.h"
#include "transports/links/pwm/pwm_medium.h"

namespace tribus {
namespace {

namespace fs = std::filesystem;

struct PwmOptions {
    std::string off;
};

/// Switches off every output that the configuration names. Chips that are not there are no mistake.
int switch_off_all(const std::string& path) {
    const auto configuration = load_or_explain(path);
    if (!configuration) {
        return kExitWrongUse;
    }
    int status = kExitFine;
    for (const OutputConfig& output : configuration->outputs) {
        if (output.port.medium != &kPwmMedium) {
            continue;
        }
        const auto chip = find_pwm_chip(output.port.device);
        for (const PwmOutput& one :
             chip ? pwm_outputs(output.settings) : std::vector<PwmOutput>{}) {
            if (const std::string problem = switch_off(*chip, one.output); !problem.empty()) {
                status = complain(problem, kExitFailed);
            }
        }
    }
    return status;
}

int run_pwm(const PwmOptions& options) {
    if (!options.off.empty()) {
        return switch_off_all(options.off);
    }
    fmt::print("{}", pwm_report());
    return kExitFine;
}

}  // namespace

std::string pwm_report(const fs::path& root) {
    std::string report;
    for (const PwmChipFacts& chip : find_pwm_chips(root)) {
        report += pwm_chip_text(chip) + "\n";
        for (std::size_t output = 0; output < chip.outputs; ++output) {
            if (const auto facts = look_at(chip, output)) {
                report += fmt::format("  output {:2}  {}\n", output, pwm_output_text(*facts));
            }
        }
    }
    return report.empty() ? "no PWM chip; a device-tree overlay, such as "
                            "dtoverlay=i2c-pwm-pca9685a on a Raspberry Pi, makes one\n"
                          : report;
}

Command pwm_command() {
    auto options = std::make_shared<PwmOptions>();
    return {
        .name = "pwm",
        .help = "List the PWM chips of this machine, or switch outputs off",
        .notes =
            "Without an option it lists chips, and those of their outputs that a program has "
            "taken.",
        .options = {{.name = "--off",
                     .value = &options->off,
                     .help = "Switch off the outputs that this configuration names, for after the "
                             "end of the daemon",
                     .value_name = "CONFIG"}},
        .examples = {{"tribus pwm", "which chips there are, and which outputs are taken"},
                     {"sudo tribus pwm --off /etc/tribus/legs.toml", ""}},
        .run = [options] { return run_pwm(*options); },
    };
}

}  // namespace tribus
