#pragma once

#include <cstddef>
#include <optional>
#include <vector>

/// What a new configuration takes over from the running one, so that a reload does not disturb
/// control. Plain indices, computed before the hand-over: the data path compares nothing and looks
/// nothing up.
namespace tribus {

/// Index of the part in the running configuration from which a new part takes over its state.
/// `nullopt`: it starts without state.
using CarriedFrom = std::optional<std::size_t>;

/// How an input continues.
struct InputCarry {
    CarriedFrom from{};
    /// Its own channel rules are unchanged, so that its slews continue.
    bool same_channels = false;
    /// Its keys have changed, but not all of them.
    bool new_keys = false;
};

/// How an output continues.
struct OutputCarry {
    CarriedFrom from{};
    bool same_channels = false;
    bool same_schedule = false;
    bool same_failsafe = false;
};

/// One entry for each part of the new engine.
struct EngineCarry {
    std::vector<InputCarry> inputs;
    std::vector<OutputCarry> outputs;
    std::vector<CarriedFrom> nodes;
};

/// One entry for each named value, sensor bus and value message of the new configuration.
struct ValueCarry {
    std::vector<CarriedFrom> values;
    std::vector<CarriedFrom> buses;
    std::vector<CarriedFrom> messages;
};

/// Parts of the running engine that the new one lacks. They send their last frames before the
/// hand-over.
struct Leaving {
    std::vector<std::size_t> outputs;
    std::vector<std::size_t> nodes;

    bool empty() const { return outputs.empty() && nodes.empty(); }
};

}  // namespace tribus
