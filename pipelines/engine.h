#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "pipelines/input.h"
#include "pipelines/output.h"

namespace tribus {

/// All inputs and outputs of a configuration, and the links between them. Makes no system call and
/// no allocation: whoever drives it (the real-time loop, or a simulation under virtual time) brings
/// received bytes, calls `poll`, and carries away what the outputs made. Thread-bound.
class Engine {
  public:
    Engine(std::vector<InputSettings> inputs, std::vector<OutputSettings> outputs);

    void start(Instant now);

    /// Bytes of one input, read at `now`. `damaged` answers [position] with whether the line
    /// damaged that byte.
    template <class DamagedMarks>
    void receive(std::size_t input, std::span<const std::uint8_t> bytes,
                 const DamagedMarks& damaged, Instant now) {
        if (inputs_[input].receive(bytes, damaged, now)) {
            announce(input);
        }
    }
    /// A CAN frame that arrived at `at` on the interface of one input.
    void receive(std::size_t input, const CanFrame& frame, Instant at) {
        if (inputs_[input].receive(frame, at)) {
            announce(input);
        }
    }
    /// A CAN frame of another node on the interface of one output.
    void watch_for_foreign_sender(std::size_t output, const CanFrame& frame, Instant at);
    void device_lost(std::size_t input) { inputs_[input].device_lost(); }

    /// Runs every output that is due at `now`, each at most once. Returns when to call next at the
    /// latest; an arriving frame may ask for it sooner, so call it after `receive` too.
    Instant poll(Instant now);

    /// Puts every output into failsafe for good: the program is about to end. Poll and write on
    /// until the returned instant, so that readers get several of the last frames.
    Instant end(Instant now);

    std::span<const Input> inputs() const { return inputs_; }
    std::span<const Output> outputs() const { return outputs_; }
    Output& output(std::size_t index) { return outputs_[index]; }

  private:
    void announce(std::size_t input);

    std::vector<Input> inputs_;
    std::vector<Output> outputs_;
};

}  // namespace tribus
