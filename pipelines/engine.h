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

    /// Bytes of one input, read at `now`, none of them damaged. Returns whether a frame came out.
    bool receive(std::size_t input, std::span<const std::uint8_t> bytes, Instant now) {
        return announce(input, inputs_[input].receive(bytes, now));
    }
    /// The same where the line damaged some. `damaged` answers [position] with whether the line
    /// damaged that byte.
    template <class DamagedMarks>
    bool receive(std::size_t input, std::span<const std::uint8_t> bytes,
                 const DamagedMarks& damaged, Instant now) {
        return announce(input, inputs_[input].receive(bytes, damaged, now));
    }
    /// A CAN frame that arrived at `at` on the interface of one input.
    bool receive(std::size_t input, const CanFrame& frame, Instant at) {
        return announce(input, inputs_[input].receive(frame, at));
    }
    /// A CAN frame of another node on the interface of one output.
    void watch_for_foreign_sender(std::size_t output, const CanFrame& frame, Instant at);
    void device_lost(std::size_t input) { inputs_[input].device_lost(); }

    /// Runs every output that is due at `now`, each at most once. Returns when to call next at the
    /// latest; an arriving frame may ask for it sooner, so call it after `receive` too.
    Instant poll(Instant now);
    /// The outputs that the last `poll` ran. A silent one has made nothing.
    std::span<const std::size_t> ran() const { return ran_; }

    /// Puts every output into failsafe for good: the program is about to end. Poll and write on
    /// until the returned instant, so that readers get several of the last frames.
    Instant end(Instant now);

    std::span<const Input> inputs() const { return inputs_; }
    std::span<const Output> outputs() const { return outputs_; }
    Output& output(std::size_t index) { return outputs_[index]; }

  private:
    bool announce(std::size_t input, bool frame_came);

    std::vector<Input> inputs_;
    std::vector<Output> outputs_;
    /// For each input, the outputs that it may feed.
    std::vector<std::vector<std::size_t>> fed_by_;
    /// When each output is due: side by side, for every wake looks through all of them.
    std::vector<Instant> due_;
    std::vector<std::size_t> ran_;
};

}  // namespace tribus
