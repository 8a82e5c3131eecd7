#pragma once

#include <cstddef>
#include <optional>
#include <vector>

/// What a new configuration goes on with of the running one, so that whoever flies or drives with
/// it does not notice the change. Plain indices, worked out before the hand-over: nothing is
/// compared or looked up on the data path.
namespace tribus {

/// The part before from which a new one goes on; nothing: it starts as never seen.
using CarriedFrom = std::optional<std::size_t>;

struct InputCarry {
    CarriedFrom from{};
    /// Its own channel rules are as before, so that a slew goes on where it is.
    bool same_channels = false;
};

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

/// Of named values: of the new board, buses and messages.
struct ValueCarry {
    std::vector<CarriedFrom> values;
    std::vector<CarriedFrom> buses;
    std::vector<CarriedFrom> messages;
};

/// Of the running engine: what the new one has not, and ends before the hand-over.
struct Leaving {
    std::vector<std::size_t> outputs;
    std::vector<std::size_t> nodes;

    bool empty() const { return outputs.empty() && nodes.empty(); }
};

}  // namespace tribus
