#include "app/pwm/pwm_text.h"

#include <chrono>
#include <ratio>

#include <fmt/format.h>

namespace tribus {

std::string pwm_chip_text(const PwmChipFacts& chip) {
    return fmt::format("{}  {}, outputs 0 to {}{}", chip.name,
                       chip.driver.empty() ? "driver unknown" : chip.driver,
                       chip.outputs == 0 ? 0 : chip.outputs - 1,
                       chip.device.empty()
                           ? ""
                           : ", with " + chip.device.string() +
                                 ": outputs that a program has by it cannot be seen");
}

std::string pwm_output_text(const PwmOutputFacts& facts) {
    using Microseconds = std::chrono::duration<double, std::micro>;
    using Milliseconds = std::chrono::duration<double, std::milli>;
    return fmt::format("{}  {:8.1f} us each {:.3f} ms", facts.on ? "on " : "off",
                       Microseconds(facts.pulse).count(), Milliseconds(facts.period).count());
}

}  // namespace tribus
