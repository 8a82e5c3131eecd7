#include "transports/links/pwm/pwm_medium.h"

#include <array>

#include "transports/links/pwm/pwm_link.h"

namespace tribus {
namespace {

constexpr std::array kPwmSettings{
    Setting{.key = "output_enable",
            .absent = "no line",
            .scope = SettingScope::output,
            .help = "GPIO line, as `GPIO22` or `gpiochip0:22`, with a square wave that only fresh "
                    "frames make: a circuit behind it holds the chip's input *output enable*. Its "
                    "period is four times that of the output",
            .example = "\"GPIO22\""},
};

}  // namespace

const Medium kPwmMedium{
    .name = "a PWM chip",
    .shape = WireShape::bytes,
    .only_own_protocols = true,
    .place = {.key = "chip",
              .required = true,
              .help = "PWM chip: \"pwmchip0\", or the name of its driver if only one has it, such "
                      "as \"pca9685-pwm\"; `tribus pwm` lists them",
              .example = "\"pca9685-pwm\""},
    .place_absent = "required on a PWM chip",
    .settings = kPwmSettings,
    .enable_key = "output_enable",
    .has_period = true,
    .users = Users::one,
    .is_missing = [](const std::string& chip) { return is_pwm_chip_missing(chip); },
    .open = [](const std::string& chip,
               const LinkUse& use) { return as_link(PwmLink::open(chip, use.period, use.worker)); },
};

}  // namespace tribus
