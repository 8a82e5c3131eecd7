#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/schedule.h"
#include "core/time.h"
#include "pipelines/channel_map.h"
#include "pipelines/input.h"
#include "pipelines/settings.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"

namespace tribus {

struct OutputSettings {
    std::string name;
    /// One of the two, as the protocol is.
    std::unique_ptr<Encoder> encoder;
    std::unique_ptr<CanEncoder> can_encoder{};
    /// CAN only: while another node goes on sending with the ids of this output, it says failsafe.
    bool yield_to_foreign_sender = true;
    ScheduleSettings schedule;
    /// What its pipeline feeds it from: indices of inputs, the preferred first.
    std::vector<std::size_t> inputs;
    std::vector<ChannelRule> channels;
    FailsafeSettings failsafe;
};

enum class OutputStage : std::uint8_t {
    failsafe,  ///< no input in control: presets, held values with flags, or silence
    holding,   ///< the input is lost: its last values, marked frame-lost
    control,   ///< an input is in control
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
    /// A frame of input `index`, which is one of `inputs()`, has arrived.
    void frame_arrived(std::size_t index, const ArrivalClock& arrivals);
    Instant due() const { return schedule_.due(); }
    /// Makes the next frame; call when due. Silence makes none.
    void run(Instant now, std::span<const Input> inputs);
    /// No input regains control from here on: the program is about to end.
    void end(Instant now);

    /// The encoded frame that waits to be written; empty if none. Taking it makes it empty.
    /// Valid until the next `run`.
    Transmission take();
    void written() { ++counts_.sent; }
    void dropped_busy() { ++counts_.busy_drops; }
    void dropped_lost() { ++counts_.lost_drops; }
    void dropped_unavailable() { ++counts_.unavailable_drops; }

    /// The ids that it sends; empty where it is not on CAN.
    std::span<const CanIdMatch> sent_ids() const;
    bool on_can() const { return can_encoder_ != nullptr; }
    bool uses_fd() const { return can_encoder_ && can_encoder_->uses_fd(); }
    /// Another node has sent one of them. One that goes on doing so pretends to be this output.
    void foreign_frame_seen(Instant now);

    const std::string& name() const { return name_; }
    /// Indices of the inputs that may feed it, the preferred first.
    std::span<const std::size_t> inputs() const { return inputs_; }
    OutputStage stage() const { return stage_; }
    /// The latest frame that it made; a default one before the first.
    const ChannelFrame& latest() const { return latest_; }
    /// When its latest frame was due.
    Instant latest_due() const { return latest_due_; }
    std::optional<std::size_t> controlling_input() const;
    const OutputCounts& counts() const { return counts_; }
    std::uint64_t overruns() const { return schedule_.overruns(); }
    Duration period() const { return schedule_.period(); }

  private:
    bool must_yield(Instant now) const;
    std::optional<std::size_t> select(Instant now, Instant at, std::span<const Input> inputs) const;
    std::optional<ChannelFrame> make_frame(Instant now, std::span<const Input> inputs);
    std::optional<ChannelFrame> failsafe_frame(Instant now);

    std::string name_;
    std::unique_ptr<Encoder> encoder_;
    std::unique_ptr<CanEncoder> can_encoder_;
    bool yield_to_foreign_sender_;
    Schedule schedule_;
    std::vector<std::size_t> inputs_;
    ChannelMap map_;
    FailsafeSettings failsafe_;

    OutputStage stage_ = OutputStage::failsafe;
    bool ending_ = false;
    Instant foreign_seen_{};
    int foreign_run_ = 0;  ///< frames of others, each soon after the one before
    Instant yield_until_{};
    /// The input that is, or before `holding` was, in control.
    std::optional<std::size_t> current_;
    std::optional<ChannelFrame> held_;
    ChannelFrame latest_;
    Instant latest_due_{};
    std::array<std::uint8_t, kLongestSerialFrame> wire_{};
    std::size_t wire_length_ = 0;
    /// Room for kMostSnapshotFrames where it is on CAN; else none.
    std::vector<CanFrame> can_frames_;
    std::size_t can_frame_count_ = 0;
    OutputCounts counts_;
};

}  // namespace tribus
