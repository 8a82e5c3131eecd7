#pragma once

#include <string>

#include "app/learn/learn_live.h"

namespace tribus {

/// A gamepad of which a person shows the controls.
struct PadToLearn {
    std::string device;
    bool grab = true;
    /// The table that gets its lines: "[input.pad] of servos.toml"; empty: none yet, so a whole one
    /// is printed.
    std::string place{};
};

/// Asks a person to move sticks and press buttons, and prints the lines of a configuration. Returns
/// the exit status. Blocks until the person is done, or does nothing for long.
int learn_pad(const PadToLearn& pad, LearnGuide guide);

}  // namespace tribus
