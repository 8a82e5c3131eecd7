#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "pipelines/carry_over.h"
#include "pipelines/dronecan/node.h"
#include "pipelines/input.h"
#include "pipelines/line_roles.h"
#include "pipelines/line_words.h"
#include "pipelines/output.h"

namespace tribus {

/// All inputs and outputs of a configuration, and the links between them. Makes no system call and
/// no allocation: whoever drives it (the real-time loop, or a simulation under virtual time) brings
/// received bytes, calls `poll`, and carries away what the outputs made. Thread-bound.
class Engine {
  public:
    Engine(std::vector<InputSettings> inputs, std::vector<OutputSettings> outputs,
           std::vector<LineTask> lines = {}, std::vector<dronecan::NodeSettings> nodes = {});

    void start(Instant now);
    /// After `start`: what `carry` names goes on at `now` as it was in `before`, which is left
    /// without use.
    void continue_from(Engine& before, const EngineCarry& carry, Instant now);

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
    /// A CAN frame of another node on the interface of one of DroneCAN's nodes.
    void receive_node(std::size_t node, const CanFrame& frame, Instant at) {
        nodes_[node]->receive(frame, at);
    }
    void device_lost(std::size_t input) { inputs_[input].device_lost(); }
    /// Bytes of one input were thrown away unread.
    void bytes_discarded(std::size_t input) { inputs_[input].bytes_discarded(); }
    /// The caller was away from `since` to `now`: stopped, starved, or suspended with the machine.
    /// Call it when all that waited was received, bytes as if they had been read at `since`. An
    /// input whose timeout is no longer than that is lost and has to prove itself anew.
    void was_away(Instant since, Instant now);
    /// When the bytes of one input that come next arrived is not known: the time since those before
    /// says nothing of pauses on the line.
    void forget_read_time(std::size_t input) { inputs_[input].forget_read_time(); }
    /// Brings the state of an input up to date; those of an output that runs are.
    void look(std::size_t input, Instant now) { inputs_[input].look(now); }

    /// The input lines say something else from `now` on. Until the first call all are there and
    /// none is active.
    void set_lines(LineLevels levels, Instant now);
    /// What the output lines are to show, but for the waves of `fresh`.
    LineStates shown_on_lines() const { return line_roles_.shown(outputs_); }

    /// Runs every output that is due at `now`, each at most once. Returns when to call next at the
    /// latest; an arriving frame may ask for it sooner, so call it after `receive` too.
    Instant poll(Instant now);
    /// The outputs that the last `poll` ran. A silent one has made nothing.
    std::span<const std::size_t> ran() const { return ran_; }

    /// Puts every output into failsafe for good: the program is about to end. Poll and write on
    /// until the returned instant, so that readers get several of the last frames.
    Instant end(Instant now);
    /// The same for some of them.
    Instant end(const Leaving& leaving, Instant now);

    std::span<const Input> inputs() const { return inputs_; }
    std::span<const Output> outputs() const { return outputs_; }
    Output& output(std::size_t index) { return outputs_[index]; }
    /// Nodes of DroneCAN. What they have to say is to be written after each `poll`.
    std::size_t node_count() const { return nodes_.size(); }
    dronecan::Node& node(std::size_t index) { return *nodes_[index]; }
    const dronecan::Node& node(std::size_t index) const { return *nodes_[index]; }

  private:
    Instant end_output(std::size_t output, Instant now);
    bool announce(std::size_t input, bool frame_came);
    Instant poll_nodes(Instant now);
    dronecan::NodeHealth health_of(std::size_t node) const;

    std::vector<Input> inputs_;
    std::vector<Output> outputs_;
    LineRoles line_roles_;
    /// Where they stand stays: outputs look at their voices.
    std::vector<std::unique_ptr<dronecan::Node>> nodes_;
    /// For each output the node in whose name it speaks.
    std::vector<std::optional<std::size_t>> node_of_;
    /// For each input, the outputs that it may feed.
    std::vector<std::vector<std::size_t>> fed_by_;
    /// When each output is due: side by side, for every wake looks through all of them.
    std::vector<Instant> due_;
    std::vector<std::size_t> ran_;
};

}  // namespace tribus
