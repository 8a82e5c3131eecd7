#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/arrival_clock.h"
#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/schedule.h"
#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/carry_over.h"
#include "pipelines/channel_map.h"
#include "pipelines/glide.h"
#include "pipelines/input.h"
#include "pipelines/input_selector.h"
#include "pipelines/line_words.h"
#include "pipelines/settings.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"

namespace tribus {

struct OutputSettings {
    std::string name;
    /// One of the two, as the protocol is.
    std::unique_ptr<Encoder> encoder;
    std::unique_ptr<CanEncoder> can_encoder{};
    /// The node of DroneCAN in whose name it speaks.
    std::optional<std::size_t> node{};
    /// CAN only: while another node goes on sending with the ids of this output, it says failsafe.
    bool yield_to_foreign_sender = true;
    ScheduleSettings schedule;
    /// What its pipeline feeds it from.
    SelectionSettings selection;
    std::vector<ChannelRule> channels;
    /// A bit for each channel that a map makes, here or at one of its inputs.
    std::uint32_t mapped_channels = 0;
    FailsafeSettings failsafe;
};

/// No input is named.
inline constexpr std::size_t kNoInput = SIZE_MAX;

enum class OutputStage : std::uint8_t {
    failsafe,     ///< no input in control: presets, held values with flags, or silence
    holding,      ///< the input is lost: its last values, marked frame-lost
    control,      ///< an input is in control
    cannot_send,  ///< whatever its inputs say: nothing leaves
};

/// What keeps an output's frames from leaving.
enum class SendObstacle : std::uint8_t {
    none,
    device,  ///< its device or interface is gone
    bus,     ///< the bus takes nothing: it is down, off, or nobody acknowledges
    busy,    ///< frame upon frame finds the one before still waiting
};

/// What an output is doing and by whom, for those who tell people.
struct OutputState {
    OutputStage stage = OutputStage::failsafe;
    SendObstacle obstacle = SendObstacle::none;
    /// In failsafe although an input is healthy: `release_when` is not true yet.
    bool awaits_release = false;
    /// In failsafe because somebody wants it: a switch, another node with its ids, the end.
    bool forced = false;
    /// The input in control: of a median the preferred one. Else, and where each frame may be of
    /// another one, kNoInput.
    std::size_t input = kNoInput;
    /// A bit for each place in the list of inputs: the others have outvoted it.
    std::uint32_t outvoted = 0;
    /// While it holds, its frames say so. Constant.
    bool marks_frame_lost = true;
    /// Channels, a bit each, for which the configuration names what does not come: they say their
    /// presets although an input is in control.
    std::uint32_t by_preset = 0;

    bool operator==(const OutputState&) const = default;
};

/// What an output hands to its link: a frame of bytes, or CAN frames, or nothing.
struct Transmission {
    std::span<const std::uint8_t> bytes;
    std::span<const CanFrame> can_frames;

    bool empty() const { return bytes.empty() && can_frames.empty(); }
};

/// Events of one output since start. Only ever incremented.
struct OutputCounts {
    std::uint64_t sent = 0;
    std::uint64_t busy_drops = 0;  ///< the port still had the frame before; a newer one follows
    std::uint64_t lost_drops = 0;  ///< the device was not there
    std::uint64_t unavailable_drops = 0;  ///< the bus took nothing: down, off, or stalled
    std::uint64_t foreign_frames = 0;     ///< CAN frames of others with the ids of this output
    std::uint64_t failsafe_entries = 0;
    std::uint64_t recoveries = 0;
    std::uint64_t changeovers = 0;  ///< from one input to another, without failsafe between
};

/// The end of a pipeline: selects the input, runs the filters, judges loss and failsafe, and
/// encodes, each time that it is due. Failsafe belongs here, to the output's own tick, because a
/// dead link delivers nothing that could trigger anything. Thread-bound, no allocation after
/// construction.
///
/// A frame speaks for the whole period until the next one, so inputs are judged by what they will
/// be at its end: no reader acts on unmarked values older than the input's timeout.
class Output {
  public:
    explicit Output(OutputSettings settings);

    void start(Instant now) { schedule_.start(now); }
    /// Where the named values are that it may send. Before `start`; must outlive it.
    void use(const ValueBoard& board);
    /// Goes on at `now` as `before`, which is the same port's output of the same protocol: what
    /// stage it is in, its rhythm, its counters. What its settings say else counts from its next
    /// frame on. An input in control that is gone is a lost one.
    void continue_from(Output& before, const OutputCarry& carry,
                       std::span<const InputCarry> carried_inputs, Instant now);
    /// In whose name it sends. As above.
    void send_as(const dronecan::NodeIdentity& identity);
    void set_period(Duration period) { schedule_.set_period(period); }
    /// A frame of input `index`, which is one of `inputs()`, has arrived.
    void frame_arrived(std::size_t index, const ArrivalClock& arrivals);
    Instant due() const { return schedule_.due(); }
    /// Makes the next frame; call when due. Silence makes none.
    void run(Instant now, std::span<const Input> inputs);
    /// No input regains control from here on: the program is about to end.
    void end(Instant now);
    /// While `on`, no input has control; afterwards as after any loss.
    void force_failsafe(bool on, Instant now);
    /// A person has chosen that one of `inputs()`, by its place; nothing: nobody.
    void pick_input(std::optional<std::size_t> place) { selector_.pick(place); }
    /// What input lines say, for channels that are made from them.
    void set_lines(LineLevels levels) { map_.set_lines(levels); }

    /// The encoded frame that waits to be written; empty if none. Taking it makes it empty.
    /// Valid until the next `run`.
    Transmission take();
    void written() {
        ++counts_.sent;
        busy_run_ = 0;
        obstacle_ = SendObstacle::none;
    }
    void dropped_busy();
    void dropped_lost();
    void dropped_unavailable();
    /// Its device is there, or is not: told also where there is nothing to write.
    void set_device_present(bool present);

    /// The ids that it sends; empty where it is not on CAN.
    std::span<const CanIdMatch> sent_ids() const;
    bool on_can() const { return can_encoder_ != nullptr; }
    bool uses_fd() const { return can_encoder_ && can_encoder_->uses_fd(); }
    /// Another node has sent one of them. One that goes on doing so pretends to be this output.
    void foreign_frame_seen(Instant now);

    const std::string& name() const { return name_; }
    /// Indices of the inputs that may feed it, the preferred first.
    std::span<const std::size_t> inputs() const { return selector_.inputs(); }
    const InputSelector& selector() const { return selector_; }
    OutputStage stage() const {
        return obstacle_ == SendObstacle::none ? stage_ : OutputStage::cannot_send;
    }
    OutputState state(Instant now) const;
    /// The latest frame that it made; a default one before the first.
    const ChannelFrame& latest() const { return latest_; }
    /// It made a frame at its latest turn.
    bool speaks() const { return spoke_; }
    /// When its latest frame was due.
    Instant latest_due() const { return latest_due_; }
    std::optional<std::size_t> controlling_input() const;
    const OutputCounts& counts() const { return counts_; }
    std::uint64_t overruns() const { return schedule_.overruns(); }
    Duration period() const { return schedule_.period(); }

  private:
    bool must_yield(Instant now) const;
    std::optional<ChannelFrame> frame_without_inputs(bool yielding);
    std::optional<ChannelFrame> make_frame(Instant now, std::span<const Input> inputs);
    std::optional<ChannelFrame> control_frame(Instant now);
    std::optional<ChannelFrame> failsafe_frame(Instant now);
    void enter_failsafe();
    void glide_from_latest(std::optional<double> us_per_second);
    void take_up_channels();
    void fill_absent(ChannelFrame& frame, Instant now);

    std::string name_;
    std::unique_ptr<Encoder> encoder_;
    std::unique_ptr<CanEncoder> can_encoder_;
    bool yield_to_foreign_sender_;
    Schedule schedule_;
    InputSelector selector_;
    std::optional<double> changeover_us_per_second_;
    ChannelMap map_;
    std::uint32_t mapped_channels_;
    std::uint32_t by_preset_ = 0;
    FailsafeSettings failsafe_;
    Glide glide_;

    /// What its inputs make of it; never `cannot_send`.
    OutputStage stage_ = OutputStage::failsafe;
    SendObstacle obstacle_ = SendObstacle::none;
    int busy_run_ = 0;  ///< frames in a row that found the one before still waiting
    bool ending_ = false;
    bool forced_ = false;
    bool awaits_release_ = false;
    Instant foreign_seen_{};
    int foreign_run_ = 0;  ///< frames of others, each soon after the one before
    Instant yield_until_{};
    std::optional<ChannelFrame> held_;
    Instant holding_since_{};
    /// The latest turn was not silent.
    bool spoke_ = false;
    ChannelFrame latest_;
    Instant latest_due_{};
    Instant latest_at_{};
    std::array<std::uint8_t, kLongestSerialFrame> wire_{};
    std::size_t wire_length_ = 0;
    /// Room for kMostSnapshotFrames where it is on CAN; else none.
    std::vector<CanFrame> can_frames_;
    std::size_t can_frame_count_ = 0;
    OutputCounts counts_;
};

}  // namespace tribus
