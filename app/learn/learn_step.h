#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tribus {

/// Prints a step for the program that guides the person, as one line of JSON. `step`: `waiting`
/// (the sticks are to be moved), `off`, `on`, `control` (a control of a gamepad is to be shown),
/// `done` or `broken`. `lines`: what was learned, as lines of a configuration.
void tell_learn_step(std::string_view step, std::string_view text,
                     const std::vector<std::string>& lines = {});

}  // namespace tribus
