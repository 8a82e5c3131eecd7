#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/arrival_clock.h"
#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/time.h"
#include "pipelines/engine/carry_over.h"
#include "pipelines/engine/change_watch.h"
#include "pipelines/rules/channel_map.h"
#include "pipelines/rules/link_supervisor.h"
#include "pipelines/rules/settings.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/line_pauses.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/read_times.h"
#include "transports/codecs/transmission.h"
#include "transports/codecs/undamaged_parts.h"

namespace tribus {

struct InputSettings {
    std::string name;
    AnyDecoder decoder;
    /// Duration of one byte on the wire. Zero if read times do not show the pauses on it.
    Duration byte_time{};
    SupervisionSettings supervision{};
    /// Rules that make the input's channels from the channels that it receives. Empty: unchanged.
    std::vector<ChannelRule> channels{};
};

/// Counters of one input since the start. They never decrease.
struct InputCounts {
    std::uint64_t bytes = 0;  ///< CAN: data bytes of the frames with the wanted ids
    std::uint64_t frames = 0;
    std::uint64_t frame_lost_frames = 0;  ///< marked by the sender
    std::uint64_t failsafe_frames = 0;    ///< marked by the sender, or by a rule
    std::uint64_t device_losses = 0;
    /// How often each cause of loss began, indexed by `LinkCause`.
    std::array<std::uint64_t, kLinkCauseCount> began{};
};

/// One source of frames. Keeps the latest frame (no queue) and judges its link. Thread-bound. No
/// allocation after construction.
class Input {
  public:
    /// `index`: of this input, stored in its frames as their source.
    Input(InputSettings settings, std::uint8_t index);

    /// Tells `watch`, which must outlive the input, each change of the cause of its state.
    void tell_changes_to(ChangeWatch& watch) { watch_ = &watch; }
    /// Takes over the state of `before`, an input with the same protocol and protocol settings, but
    /// for its keys: a frame received in part, the state of the link and the counters. `before` is
    /// unusable afterwards.
    void continue_from(Input& before, const InputCarry& carry, Instant now);

    /// Takes bytes that were read at `now`. Returns true if they completed a frame.
    bool receive(std::span<const std::uint8_t> bytes, Instant now) {
        const bool any = arrived(bytes.size(), now);
        return decode(bytes, now) || any;
    }
    /// The same; `damaged[i]` is true if byte i was damaged on the line.
    template <class DamagedMarks>
    bool receive(std::span<const std::uint8_t> bytes, const DamagedMarks& damaged, Instant now) {
        bool any = arrived(bytes.size(), now);
        for_undamaged_parts(
            bytes, damaged,
            [&](std::span<const std::uint8_t> part) { any = decode(part, now) || any; },
            [&] { byte_decoder().damaged_byte(); });
        return any;
    }
    /// Takes one CAN frame that arrived at `at`. Returns true if it completed a frame of channels.
    /// Ignores unwanted ids.
    bool receive(const CanFrame& frame, Instant at);
    /// Ends the frame received in part: no byte of it will follow. Returns true if the end
    /// completed a frame.
    bool datagram_ended(Instant now) { return pause(now); }
    /// Its protocol answers at `now` the sender of what was received last. Empty: it says nothing.
    /// Valid until the next call.
    Transmission answer(Instant now);
    /// Discards a frame received in part and counts the loss of the device.
    void device_lost();
    /// Call after the caller did not read from `since` to `now`. Before, pass the waiting bytes to
    /// `receive` with the time `since`, because they may be that old, or discard them.
    void was_away(Instant since, Instant now) {
        supervisor_.was_away(since, now);
        forget_read_time();
        looked_at_ = kNever;
    }
    /// Call when bytes after the received ones were discarded: ends the frame received in part.
    void bytes_discarded() { start_anew(); }
    /// Call when the time since the latest bytes does not show a pause on the line.
    void forget_read_time() { ongoing_.pauses.forget(); }

    /// Whether its frames count, since when, until when, and why not.
    const LinkSupervisor& link() const { return supervisor_; }
    /// State of the link at the latest frame or call of `look`.
    const LinkState& state() const { return ongoing_.state; }
    /// The latest loss of the link. `good`: there was none.
    const LinkState& latest_loss() const { return ongoing_.loss; }
    /// When that began or ended, whichever is later.
    Instant latest_loss_at() const { return ongoing_.loss_at; }
    /// What its decoder says of frames that do not count, if it is the decoder that refuses them or
    /// marks them failsafe. Empty: it says nothing.
    FaultText fault() const;
    /// Updates `state`, the counters of causes and slews.
    void look(Instant now) {
        if (now != looked_at_) {
            judge(now);
            if (has_slews_) {
                move_slews(now);
            }
        }
    }

    /// The values of the latest good frame, after the input's own channel rules. Marked frame-lost
    /// if the newest frame is not good.
    const ChannelFrame& control() const { return map_ ? mapped_ : supervisor_.control(); }
    /// `control` without the slews of its rules: what the sticks say.
    ChannelFrame aim() const {
        return map_ ? map_->aim(supervisor_.control()) : supervisor_.control();
    }
    /// Its own channel rules. Null if it has none.
    const ChannelMap* map() const { return map_ ? &*map_ : nullptr; }
    /// The latest frame as received, good or not.
    const ChannelFrame& latest() const { return ongoing_.latest; }
    const ArrivalClock& arrivals() const { return ongoing_.arrivals; }
    const InputCounts& counts() const { return ongoing_.counts; }
    const DecoderReport& decoder() const;
    /// The CAN ids that it receives. Empty if it is not on CAN.
    std::span<const CanIdMatch> wanted_ids() const;
    /// The CAN ids with which it answers.
    std::span<const CanIdMatch> answered_ids() const;
    bool on_can() const { return can_decoder() != nullptr; }
    bool uses_fd() const { return on_can() && can_decoder()->uses_fd(); }
    const std::string& name() const { return name_; }

  private:
    /// A reload keeps this state, besides the decoder and the state of the link.
    struct Ongoing {
        /// Maps positions in the received bytes to the times at which they were read.
        ReadTimes read_times{};
        LinePauses pauses;
        LinkState state{};
        LinkState loss{.cause = LinkCause::good};
        Instant loss_at{};
        ChannelFrame latest{};
        ArrivalClock arrivals{};
        InputCounts counts{};
    };

    /// Only for an input whose protocol is on bytes.
    ByteDecoder& byte_decoder() const {
        return **std::get_if<std::unique_ptr<ByteDecoder>>(&decoder_);
    }
    /// Null if its protocol is not on CAN.
    CanDecoder* can_decoder() const {
        const auto* can = std::get_if<std::unique_ptr<CanDecoder>>(&decoder_);
        return can != nullptr ? can->get() : nullptr;
    }
    void count_bytes(std::size_t count, Instant now) {
        ongoing_.counts.bytes += count;
        supervisor_.bytes_came(now);
        looked_at_ = kNever;
    }
    /// Call before the bytes are decoded. Returns true if the pause before them completed a frame.
    bool arrived(std::size_t count, Instant now) {
        count_bytes(count, now);
        ongoing_.read_times.add(ongoing_.counts.bytes, now);
        return ongoing_.pauses.before(count, now, byte_decoder().waiting()) && pause(now);
    }
    bool pause(Instant now);
    void start_anew();
    bool decode(std::span<const std::uint8_t> bytes, Instant now);
    void take_decoded(Instant now);
    void judge(Instant now);
    void change_state(const LinkState& fresh, Instant now);
    void move_slews(Instant now);
    void supervise_and_map(ChannelFrame& frame, Instant arrival, Instant now);
    /// Takes a frame that arrived at `arrival`, not later than `now`. Changes its flags, as
    /// LinkSupervisor::take.
    void take(ChannelFrame& frame, Instant arrival, Instant now);

    std::string name_;
    AnyDecoder decoder_;
    DecodedFrame decoded_;
    std::uint8_t index_;
    bool has_slews_ = false;

    LinkSupervisor supervisor_;
    /// Absent: the channels pass unchanged.
    std::optional<ChannelMap> map_;
    ChannelFrame mapped_;
    Ongoing ongoing_;
    /// `state` is of then. `kNever`: something came since.
    Instant looked_at_ = kNever;
    /// Null: nobody is told.
    ChangeWatch* watch_ = nullptr;
};

}  // namespace tribus
