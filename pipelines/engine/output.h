#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/arrival_clock.h"
#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/schedule.h"
#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/engine/carry_over.h"
#include "pipelines/engine/change_watch.h"
#include "pipelines/engine/input.h"
#include "pipelines/engine/input_selector.h"
#include "pipelines/engine/output_wait.h"
#include "pipelines/rules/channel_map.h"
#include "pipelines/rules/glide.h"
#include "pipelines/rules/line_words.h"
#include "pipelines/rules/settings.h"
#include "transports/codecs/frame_encoder.h"

namespace tribus {

struct OutputSettings {
    std::string name;
    AnyEncoder encoder;
    /// Index of the DroneCAN node whose id it sends with.
    std::optional<std::size_t> node{};
    /// CAN only: go to failsafe while another node sends with the ids of this output.
    bool yield_to_foreign_sender = true;
    ScheduleSettings schedule;
    /// Limits of a period that the receiver of the frames asks for: the time of a frame on the
    /// wire, and the slowest rate that is a link.
    Duration least_asked_period = std::chrono::milliseconds(1);
    static constexpr Duration kMostAskedPeriod = std::chrono::milliseconds(50);
    /// The inputs of its pipeline, and how one is selected.
    SelectionSettings selection;
    std::vector<ChannelRule> channels;
    /// One bit for each channel that a map makes, here or at one of its inputs.
    std::uint32_t mapped_channels = 0;
    FailsafeSettings failsafe;
};

/// Value of `OutputState::input` if no input is in control.
inline constexpr std::size_t kNoInput = SIZE_MAX;

/// What an output does. `cannot_send` takes precedence over the others.
enum class OutputStage : std::uint8_t {
    failsafe,     ///< no input in control: presets, held values with flags, or silence
    holding,      ///< the input is lost: the last values, marked frame-lost
    control,      ///< an input is in control
    cannot_send,  ///< frames do not leave, whatever the inputs say
};

/// Why an output's frames do not leave.
enum class SendObstacle : std::uint8_t {
    none,
    device,    ///< the device or interface is gone
    bus,       ///< the bus is down, off, or no node acknowledges
    busy,      ///< many frames in a row find the frame before still waiting
    receiver,  ///< no receiver with the same key answers
    epoch,     ///< no number is stored that it may use
};

/// What an output does and by which input, for status and log.
struct OutputState {
    OutputStage stage = OutputStage::failsafe;
    SendObstacle obstacle = SendObstacle::none;
    /// In failsafe although an input is healthy: `release_when` does not hold yet.
    bool awaits_release = false;
    /// In failsafe by request: a GPIO line, another node with the same ids, or the end of the
    /// program.
    bool forced = false;
    /// Index of the input in control. In median mode: the preferred input. `kNoInput` if no input
    /// is in control, or if each frame may come from another input.
    std::size_t input = kNoInput;
    /// One bit for each index in the list of inputs that is outvoted.
    std::uint32_t outvoted = 0;
    /// Whether held values are marked in its frames. Constant.
    bool marks_frame_lost = true;
    /// One bit for each channel that is sent as its preset although an input is in control, because
    /// the configuration maps it from a channel that is absent.
    std::uint32_t by_preset = 0;
    /// Whether the receiver of its frames is heard.
    Hearing hearing = Hearing::not_awaited;

    bool operator==(const OutputState&) const = default;
};

/// Counters of one output since the start. They never decrease.
struct OutputCounts {
    std::uint64_t frames = 0;             ///< handed over
    std::uint64_t busy_drops = 0;         ///< the port still had the frame before
    std::uint64_t lost_drops = 0;         ///< the device was missing
    std::uint64_t unavailable_drops = 0;  ///< the bus was down, off or stalled
    std::uint64_t foreign_frames = 0;     ///< CAN frames of other nodes with the ids of this output
    std::uint64_t hold_entries = 0;       ///< times that it began to hold the last values
    std::uint64_t failsafe_entries = 0;
    std::uint64_t recoveries = 0;
    std::uint64_t changeovers = 0;  ///< from one input to another, without failsafe between
};

/// The end of a pipeline: each time that it is due, it selects the input, runs the filters, judges
/// loss and failsafe, and encodes. Failsafe belongs here because a dead link delivers nothing that
/// could trigger it. Thread-bound. No allocation after construction.
///
/// A frame is valid for the whole period until the next one. Inputs are judged by their state at
/// the end of it, so that no reader acts on unmarked values older than the input's timeout.
class Output {
  public:
    explicit Output(OutputSettings settings);

    /// Starts the schedule.
    void start(Instant now) {
        schedule_.start(now);
        ongoing_.stage_since = now;
    }
    /// Tells `watch`, which must outlive the output, after each run that changed its state; it is
    /// the output of that index.
    void tell_changes_to(ChangeWatch& watch, std::size_t index) {
        watch_ = &watch;
        index_ = index;
    }
    /// Sets the source of named values. Call before `start`. `board` must outlive the output.
    void use(const ValueBoard& board) { encoder_.encoder().use(board); }
    /// Takes the slews in the maps of its inputs, of the engine's `inputs`. Call before `start`.
    void take_slews(std::span<const Input> inputs) { selector_.take_slews(inputs); }
    /// Takes over at `now` from `before`, an output of the same protocol on the same port: its
    /// stage, schedule and counters. Other settings apply from the next frame on. If the input in
    /// control was removed, it counts as lost.
    void continue_from(Output& before, const OutputCarry& carry,
                       std::span<const InputCarry> carried_inputs, Instant now);
    /// Sets the node that it sends as. Call before `start`; the node must outlive the output.
    void send_as(const dronecan::NodeIdentity& identity) { encoder_.encoder().send_as(identity); }
    /// Changes the period from the next frame on.
    void set_period(Duration period) { schedule_.set_period(period); }
    /// Takes undamaged bytes that came back on its line, read at `now`. They may ask for a timing.
    void hear(std::span<const std::uint8_t> bytes, Instant now);
    /// Takes a CAN frame that arrived at `at`, which may be an answer to its frames.
    void hear(const CanFrame& frame, Instant at) { encoder_.hear(frame, at); }
    /// The CAN ids of answers to its frames.
    std::span<const CanIdMatch> heard_ids() const { return encoder_.heard(); }
    /// Tells it that bytes are missing behind those it heard so far.
    void forget_heard() { encoder_.forget_heard(); }
    /// A frame of input `index`, one of `inputs()`, has arrived.
    void frame_arrived(std::size_t index, const ArrivalClock& arrivals);
    /// When to call `run` next.
    Instant due() const { return schedule_.due(); }
    /// Makes the next frame. Call when due. A silent output makes none, but in some protocols
    /// something that says so.
    void run(Instant now, std::span<const Input> inputs);
    /// Enters failsafe for good: the program is about to end.
    void end(Instant now);
    /// How many last frames it wants to send after `end`. 0: as many as any output.
    int farewells() const { return encoder_.encoder().farewells(); }
    /// While `on`, no input has control. Afterwards `recover` applies, as after a loss.
    void force_failsafe(bool on, Instant now);
    /// Selects the input at that index of `inputs()`. `nullopt`: no selection.
    void pick_input(std::optional<std::size_t> place) { selector_.pick(place); }
    /// Sets the levels of input lines, for channels that are made from them.
    void set_lines(LineLevels levels) { map_.set_lines(levels); }

    /// Takes the encoded frame, or what a silent output sends. Empty if there is none, and after it
    /// was taken. Valid until the next `run`.
    Transmission take() { return std::exchange(transmission_, {}); }
    /// Tells what became of the frame, not of what a silent output sends: handed over, or dropped
    /// because the port was busy, its device missing or its bus unavailable.
    void written() {
        ++ongoing_.counts.frames;
        ongoing_.busy_run = 0;
        ongoing_.obstacle = SendObstacle::none;
    }
    void dropped_busy();
    void dropped_lost();
    void dropped_unavailable();
    /// Whether its device is there. Call also if there is nothing to write.
    void set_device_present(bool present);

    /// The CAN ids that it sends. Empty if it is not on CAN.
    std::span<const CanIdMatch> sent_ids() const { return encoder_.encoder().sent(); }
    bool on_can() const { return encoder_.on_can(); }
    bool uses_fd() const { return encoder_.encoder().uses_fd(); }
    /// Another node has sent one of these ids. If it goes on, it counts as a second sender.
    void foreign_frame_seen(Instant now);

    const std::string& name() const { return name_; }
    /// Indices of the inputs that may feed it, the preferred one first.
    std::span<const std::size_t> inputs() const { return selector_.inputs(); }
    const InputSelector& selector() const { return selector_; }
    OutputStage stage() const {
        return ongoing_.obstacle == SendObstacle::none ? ongoing_.stage : OutputStage::cannot_send;
    }
    OutputState state(Instant now) const;
    /// Since when the stage is so, as far as the calls show, which should be a few a second; of
    /// `holding`: since the values were lost.
    Instant look_at_stage(Instant now);
    /// What it waits for at `now` while no input is in control.
    OutputWait wait(Instant now, std::span<const Input> inputs) const;
    /// Whether an input could control it at `now`, as far as the input itself is concerned. False
    /// for an input of others.
    bool could_use(std::size_t input, Instant now, std::span<const Input> inputs) const;
    /// The latest frame that it made. A default frame before the first.
    const ChannelFrame& latest() const { return ongoing_.latest; }
    /// Whether the latest `run` made a frame.
    bool sends() const { return ongoing_.made_frame; }
    /// Whether `end` was called.
    bool ends() const { return ending_; }
    /// Whether it has frames to send in its present stage. In failsafe it may have none.
    bool has_frames() const {
        return stage() != OutputStage::failsafe || failsafe_.action == FailsafeAction::preset ||
               (failsafe_.action == FailsafeAction::hold && ongoing_.held);
    }
    /// When its latest frame was due.
    Instant latest_due() const { return ongoing_.latest_due; }
    /// Index of the input in control. `nullopt` if none is.
    std::optional<std::size_t> controlling_input() const;
    /// What was heard of the receiver of its frames.
    Answers answers() const { return ongoing_.answers; }
    const OutputCounts& counts() const { return ongoing_.counts; }
    std::uint64_t overruns() const { return schedule_.overruns(); }
    Duration period() const { return schedule_.period(); }

  private:
    /// Longer than the period of any sender that a reader would confuse with this output.
    static constexpr Duration kForeignSenderMemory = std::chrono::seconds(1);
    /// Fewer frames are no second sender: they may be left over in the controller from a program
    /// that has just ended, or come from a test. Readers of a protected format reject them.
    static constexpr int kForeignSenderFrames = 3;

    /// A reload keeps this state, whatever the settings are.
    struct Ongoing {
        Glide glide{};
        /// Stage that results from the inputs; never `cannot_send`.
        OutputStage stage = OutputStage::failsafe;
        SendObstacle obstacle = SendObstacle::none;
        bool forced = false;
        bool awaits_release = false;
        int busy_run = 0;  ///< frames in a row that found the frame before still waiting
        /// The pulse that `release_when` judged. Absent: its channel is.
        std::optional<Pulse> release_pulse{};
        Instant foreign_seen{};
        /// Frames of other nodes in a row, each within a second of the one before.
        int foreign_run = 0;
        Instant yield_until{};
        std::optional<ChannelFrame> held{};
        /// When the values that are held were lost; in control, when they will be if no frame
        /// follows.
        Instant holding_since{};
        /// The latest `run` made a frame.
        bool made_frame = false;
        ChannelFrame latest{};
        Instant latest_due{};
        Instant latest_at{};
        OutputCounts counts{};
        Answers answers{};
        /// What `look_at_stage` found, and when first.
        OutputStage stage_before = OutputStage::failsafe;
        Instant stage_since{};
        /// `stand` when `ChangeWatch` was told last.
        std::uint32_t told_stand = 0;
    };

    /// What differs from run to run only if the state does. Zero before the first run.
    std::uint32_t stand() const {
        constexpr unsigned kByte = 8;
        return static_cast<std::uint32_t>(ongoing_.stage) |
               static_cast<std::uint32_t>(ongoing_.obstacle) << kByte |
               static_cast<std::uint32_t>(ongoing_.forced) << 2 * kByte |
               static_cast<std::uint32_t>(ongoing_.awaits_release) << 3 * kByte;
    }
    void tell_change(Instant now);
    bool must_yield(Instant now) const;
    bool make_frame_without_inputs(ChannelFrame& frame, bool yielding);
    bool make_frame(ChannelFrame& frame, Instant now, std::span<const Input> inputs);
    bool make_first_control_frame(ChannelFrame& frame, Instant now, std::span<const Input> inputs);
    bool make_control_frame(ChannelFrame& frame, Instant now, std::span<const Input> inputs);
    bool make_failsafe_frame(ChannelFrame& frame, Instant now);
    void look_for_withheld();
    void enter_failsafe();
    void glide_from_latest(std::optional<double> us_per_second);
    void glide_to_another_input();
    void retime_glide(const Output& before);
    void rest_slews(bool after_failsafe);
    /// A glide that is under way rests while values are held.
    bool glides_into_failsafe() const {
        return failsafe_.slew_us_per_second || failsafe_.action != FailsafeAction::hold;
    }
    bool released(const ChannelFrame& frame, std::span<const Input> inputs);
    void take_up_channels();
    void fill_absent(ChannelFrame& frame, Instant now);

    std::string name_;
    FrameEncoder encoder_;
    bool yield_to_foreign_sender_;
    Schedule schedule_;
    InputSelector selector_;
    std::optional<double> changeover_us_per_second_;
    ChannelMap map_;
    std::uint32_t mapped_channels_;
    std::uint32_t by_preset_ = 0;
    FailsafeSettings failsafe_;
    Ongoing ongoing_;
    bool ending_ = false;
    /// When the frame of the latest `run` would be judged differently.
    Instant valid_until_ = kNever;
    Transmission transmission_;
    /// Lower limit of a period that the receiver asks for.
    Duration least_asked_period_;
    bool may_withhold_;
    /// Null: nobody is told.
    ChangeWatch* watch_ = nullptr;
    std::size_t index_ = 0;
};

}  // namespace tribus
