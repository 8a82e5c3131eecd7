#pragma once

#include <cstddef>
#include <cstdint>

#include "core/can_bus_state.h"
#include "core/time.h"
#include "pipelines/dronecan/node.h"
#include "pipelines/engine/output.h"
#include "pipelines/rules/link_supervisor.h"

namespace tribus {

/// How an input, an output, a CAN interface or a DroneCAN node is.
struct PartState {
    /// Of an input. `unproved` instead of `good` while no output can use its frames.
    LinkState link{};
    /// Of an output, and whether it sends anything.
    OutputState output{};
    bool sends = false;
    CanBusState bus = CanBusState::ready;
    dronecan::NodeState node{};
};

/// A change of state of one part.
struct Change {
    /// `bus`: a CAN interface; its index is that of its port.
    enum class Part : std::uint8_t { input, output, bus, node };

    std::uint64_t number = 0;  ///< 1 for the first change, and so on
    Instant at{};
    Part part = Part::input;
    std::size_t index = 0;
    PartState was{};
    PartState now{};
};

/// Takes the changes of an engine, each at its moment.
class ChangeSink {
  public:
    /// Gives the change its number.
    virtual void add(Change change) = 0;

  protected:
    ~ChangeSink() = default;
};

}  // namespace tribus
