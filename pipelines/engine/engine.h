#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "pipelines/dronecan/node.h"
#include "pipelines/engine/carry_over.h"
#include "pipelines/engine/change.h"
#include "pipelines/engine/change_watch.h"
#include "pipelines/engine/input.h"
#include "pipelines/engine/line_roles.h"
#include "pipelines/engine/output.h"
#include "pipelines/rules/line_words.h"

namespace tribus {

/// All inputs and outputs of a configuration and the connections between them. Makes no system call
/// and does not allocate. The caller (the real-time loop, or a simulation under virtual time)
/// passes received bytes, calls `poll` and sends what the outputs made. Thread-bound.
class Engine final : private ChangeWatch {
  public:
    Engine(std::vector<InputSettings> inputs, std::vector<OutputSettings> outputs,
           std::vector<LineTask> lines = {}, std::vector<dronecan::NodeSettings> nodes = {});

    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;

    /// Tells `sink`, which must outlive the engine, each change of state of a part.
    void tell_changes_to(ChangeSink& sink) { changes_ = &sink; }
    void start(Instant now);
    /// Call after `start`. The parts named in `carry` take over their state in `before`, which is
    /// unusable afterwards.
    void continue_from(Engine& before, const EngineCarry& carry, Instant now);

    /// Takes undamaged bytes of one input, read at `now`. Returns true if they completed a frame.
    bool receive(std::size_t input, std::span<const std::uint8_t> bytes, Instant now) {
        return announce(input, inputs_[input].receive(bytes, now));
    }
    /// The same for bytes with damage. `damaged[i]` is true if byte i was damaged on the line.
    template <class DamagedMarks>
    bool receive(std::size_t input, std::span<const std::uint8_t> bytes,
                 const DamagedMarks& damaged, Instant now) {
        return announce(input, inputs_[input].receive(bytes, damaged, now));
    }
    /// The bytes received so far were a datagram: what is unfinished in it will not be completed.
    /// Returns true if its end completed a frame.
    bool datagram_ended(std::size_t input, Instant now) {
        return announce(input, inputs_[input].datagram_ended(now));
    }
    /// Takes a CAN frame that arrived at `at` on the interface of one input.
    bool receive(std::size_t input, const CanFrame& frame, Instant at) {
        return announce(input, inputs_[input].receive(frame, at));
    }
    /// Takes a CAN frame of another node on the interface of one output.
    void watch_for_foreign_sender(std::size_t output, const CanFrame& frame, Instant at);
    /// Takes undamaged bytes that came back on the line of one output, read at `now`.
    void hear(std::size_t output, std::span<const std::uint8_t> bytes, Instant now) {
        outputs_[output].hear(bytes, now);
        due_[output] = outputs_[output].due();
    }
    /// The same for a CAN frame that arrived at `at`.
    void hear(std::size_t output, const CanFrame& frame, Instant at) {
        outputs_[output].hear(frame, at);
    }
    /// One input answers the sender of what it received last: see Input::answer.
    Transmission answer(std::size_t input, Instant now) { return inputs_[input].answer(now); }
    /// Tells one output that bytes are missing behind those it heard so far.
    void forget_heard(std::size_t output) { outputs_[output].forget_heard(); }
    /// The device of one input is gone.
    void device_lost(std::size_t input) { inputs_[input].device_lost(); }
    /// Unread bytes of one input were discarded.
    void bytes_discarded(std::size_t input) { inputs_[input].bytes_discarded(); }
    /// Call after the caller did not run from `since` to `now` (stopped, starved, or suspended with
    /// the machine) and after all waiting bytes were received with the time `since`. An input whose
    /// timeout is not longer than that is lost and has to recover.
    void was_away(Instant since, Instant now);
    /// The arrival time of the next bytes of that input is unknown: the time since the bytes before
    /// does not show a pause on the line.
    void forget_read_time(std::size_t input) { inputs_[input].forget_read_time(); }
    /// Updates the state of an input. `poll` does so for the inputs of each output that it runs.
    void look(std::size_t input, Instant now) { inputs_[input].look(now); }

    /// Sets the levels of the input lines from `now` on. Before the first call all are readable and
    /// none is active.
    void set_lines(LineLevels levels, Instant now);
    /// What the output lines show, except the waves of `fresh`.
    LineStates shown_on_lines() const { return line_roles_.shown(outputs_); }

    /// Runs every output that is due at `now`, each at most once. Returns the time of the next call
    /// at the latest. A frame can make an output due sooner, so call it after `receive` too.
    Instant poll(Instant now);
    /// Indices of the outputs that the last `poll` ran. A silent output has made no frame.
    std::span<const std::size_t> ran() const { return ran_; }

    /// Puts every output into failsafe for good: the program is about to end. Go on calling `poll`
    /// and writing until the returned instant, so that readers get several of the last frames.
    Instant end(Instant now);
    /// The same for some of the outputs and nodes.
    Instant end(const Leaving& leaving, Instant now);

    /// Tells what an output waits for at `now` while no input is in control.
    OutputWait wait(std::size_t output, Instant now) const {
        return outputs_[output].wait(now, inputs_);
    }
    /// State of an input for whoever reads it: `unproved` instead of `good` while it feeds outputs
    /// and none of them could use its frames at `now`.
    LinkState input_state(std::size_t input, Instant now) const;
    /// The same for `now`, and the state of an output. A change that shows itself in no frame of an
    /// output is told by these calls, which should be a few a second.
    LinkState tell_input(std::size_t input, Instant now);
    OutputState tell_output(std::size_t output, Instant now);

    std::span<const Input> inputs() const { return inputs_; }
    std::span<const Output> outputs() const { return outputs_; }
    Output& output(std::size_t index) { return outputs_[index]; }
    /// DroneCAN nodes. After each `poll`, write what they have to send.
    std::size_t node_count() const { return nodes_.size(); }
    dronecan::Node& node(std::size_t index) { return *nodes_[index]; }
    const dronecan::Node& node(std::size_t index) const { return *nodes_[index]; }

  private:
    void input_changed(std::size_t input, Instant now) override { tell_input(input, now); }
    void output_changed(std::size_t output, Instant now) override;
    PartState state_of(std::size_t output, Instant now) const;
    void add(Change change);
    Instant end_output(std::size_t output, Instant now);
    bool announce(std::size_t input, bool frame_came);
    Instant poll_nodes(Instant now);
    void tell_node(std::size_t node, Instant now);
    dronecan::NodeHealth health_of(std::size_t node) const;

    std::vector<Input> inputs_;
    std::vector<Output> outputs_;
    LineRoles line_roles_;
    /// Pointers, because outputs keep references to them.
    std::vector<std::unique_ptr<dronecan::Node>> nodes_;
    std::vector<dronecan::NodeState> told_nodes_;
    /// Index of the DroneCAN node that each output sends as.
    std::vector<std::optional<std::size_t>> node_of_;
    /// Indices of the outputs that each input may feed.
    std::vector<std::vector<std::size_t>> fed_by_;
    /// When each output is due. Kept together because every wake-up searches all of them.
    std::vector<Instant> due_;
    std::vector<std::size_t> ran_;
    /// Null: nobody is told.
    ChangeSink* changes_ = nullptr;
    /// What the newest change of each input, and of each output, says of it.
    std::vector<PartState> told_inputs_;
    std::vector<PartState> told_outputs_;
};

}  // namespace tribus
