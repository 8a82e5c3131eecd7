#include "app/pwm/pwm.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <system_error>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "transports/codecs/pwm/pwm.h"
#include "transports/links/pwm/pwm_medium.h"

namespace tribus {
namespace {

namespace fs = std::filesystem;

constexpr double kNanosecondsAMicrosecond = 1000;
constexpr double kNanosecondsAMillisecond = 1e6;

struct PwmOptions {
    std::string off;
};

double number_in(const fs::path& path) {
    std::ifstream file(path);
    std::string text;
    std::getline(file, text);
    return std::strtod(text.c_str(), nullptr);
}

/// What an output in use does; nothing for others.
std::optional<std::string> output_line(const PwmChipFacts& chip, std::size_t output) {
    const fs::path folder = chip.folder / fmt::format("pwm{}", output);
    std::error_code error;
    if (!fs::exists(folder, error)) {
        return std::nullopt;
    }
    const bool on = number_in(folder / "enable") != 0;
    return fmt::format("  output {:2}  {}  {:8.1f} us each {:.3f} ms\n", output, on ? "on " : "off",
                       number_in(folder / "duty_cycle") / kNanosecondsAMicrosecond,
                       number_in(folder / "period") / kNanosecondsAMillisecond);
}

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
        report += fmt::format("{}  {}, outputs 0 to {}\n", chip.name,
                              chip.driver.empty() ? "driver unknown" : chip.driver,
                              chip.outputs == 0 ? 0 : chip.outputs - 1);
        for (std::size_t output = 0; output < chip.outputs; ++output) {
            report += output_line(chip, output).value_or("");
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
        .footer =
            "Without an option it lists chips, and those of their outputs that a program has "
            "taken.",
        .options = {{.name = "--off",
                     .value = &options->off,
                     .help = "Switch off the outputs that this configuration names, for after the "
                             "end of the daemon",
                     .type_name = "CONFIG"}},
        .run = [options] { return run_pwm(*options); },
    };
}

}  // namespace tribus
