#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/pulse.h"
#include "core/time.h"
#include "pipelines/rules/channel_lanes.h"
#include "pipelines/rules/settings.h"
#include "transports/codecs/codec.h"

namespace tribus {

/// State of a link at an instant.
struct LinkState {
    LinkCause cause = LinkCause::never_seen;
    RadioLossSign sign = RadioLossSign::none;
    /// When the state began. Meaningless for a link that was never seen.
    Instant since{};
};

/// Frames of an input with values that no transmitter sends.
struct ImplausibleFrames {
    std::uint64_t frames = 0;  ///< since the start
    Instant at{};              ///< of the latest
    /// A value of the latest.
    std::size_t channel = 0;
    Pulse pulse{};
    /// The range that it missed. Absent: its raw value is zero, which means "no value" at the start
    /// and after a loss.
    std::optional<PulseRange> plausible{};
};

/// How far the run of good frames of a link has got.
struct LinkRun {
    Duration time{};
    std::uint64_t frames = 0;
    Duration good_frame_age{};
};

/// Judges whether the frames of one input count, and if not, why: the sender's flags, values that
/// mean loss, silence, frames that do not change, implausible values, missing channels. Pure.
/// Thread-bound. No allocation after construction.
class LinkSupervisor {
  public:
    explicit LinkSupervisor(SupervisionSettings settings);
    /// `decoder` knows more of bytes that are no frames. It must outlive this.
    void ask(const DecoderReport& decoder) { decoder_ = &decoder; }

    /// Takes over the state of `before` at `now` and judges by its own settings. `before` is
    /// unusable afterwards. A shorter timeout applies at once, a longer one from the next good
    /// frame on.
    void continue_from(LinkSupervisor& before, Instant now);

    /// Bytes arrived, whether or not they complete a frame.
    void bytes_came(Instant now);
    /// Call after the caller did not read from `since` to `now` and after the waiting frames were
    /// taken. If that lasted for the timeout or longer, the link was lost at `since + timeout`, and
    /// an output that holds values may use it again only after it has recovered.
    void was_away(Instant since, Instant now);
    /// How often `was_away` lost the link.
    std::uint64_t absences() const { return absences_; }
    Duration timeout() const { return settings_.timeout; }
    /// Takes a whole frame that arrived at `now`. Clears flags that the settings ignore. Sets the
    /// failsafe flag if the frame means that the radio link is lost (flag, rule or ratio).
    void take(ChannelFrame& frame, Instant now);

    /// Whether its frames count at `at`, which may lie shortly in the future.
    bool alive(Instant at) const {
        return ever_good_ && !radio_lost_ && !channels_missing_ && at < expires_;
    }
    /// When the link was lost, or will be lost if no frame follows. Requires `ever_good()`. A
    /// failsafe flag that comes after the timeout does not change it.
    Instant lost_at() const {
        const Instant radio = radio_lost_ ? radio_lost_since_ : expires_;
        const Instant channels = channels_missing_ ? channels_missing_since_ : expires_;
        return std::min({radio, channels, expires_});
    }
    /// When a link that is alive will be lost if no frame follows.
    Instant alive_until() const { return expires_; }
    bool ever_good() const { return ever_good_; }
    /// Start of the run of good frames: the time in which the newest good frame was never older
    /// than the timeout. Frames that are marked frame-lost, or are not plausible, do not end it.
    Instant run_start() const { return run_start_; }
    /// Whether that run has proved the link at `now`: it has lasted for `proof`, with three good
    /// frames or more. Without a `proof` there is nothing to prove.
    bool has_proved(Duration proof, Instant now) const {
        return now - run_start_ >= proof &&
               (proof == Duration::zero() ||
                (run_frames_ >= kProofFrames && now - good_.received <= settings_.timeout));
    }
    /// Good frames that a run needs. Fewer may be chance.
    static constexpr std::uint64_t kProofFrames = 3;
    LinkRun run(Instant now) const { return {now - run_start_, run_frames_, now - good_.received}; }
    static constexpr std::size_t kRatioFrames = 100;
    /// How many of the latest `kRatioFrames` frames were marked frame-lost.
    std::size_t marked_of_latest() const { return lost_count_; }
    const ImplausibleFrames& implausible() const { return implausible_; }
    /// True while the link was never lost after its first good frame: there is nothing to recover
    /// from.
    bool first_run() const { return runs_ <= 1; }
    /// The values of the latest good frame, marked frame-lost if a newer frame was not good.
    const ChannelFrame& control() const { return good_; }

    /// State at `now`, which must not lie before the latest call.
    LinkState state(Instant now) const;

  private:
    enum class Kind : std::uint8_t { good, frame_lost, radio_lost, implausible, channels_missing };
    struct Verdict {
        Kind kind = Kind::good;
        RadioLossSign sign = RadioLossSign::none;
    };

    void watch_for_change(const ChannelFrame& frame, Kind kind, Instant now);
    Verdict judge(const ChannelFrame& frame, Instant now);
    void accept(const ChannelFrame& frame, Instant now);
    /// Whether the frame has the channels of the latest good one, except optional ones.
    bool has_needed(const ChannelFrame& frame) const;
    bool channels_missing(const ChannelFrame& frame, Instant now);
    void refuse(Verdict verdict, Instant now);
    bool rule_says_loss(const ChannelFrame& frame) const;
    bool all_zero(const ChannelFrame& frame) const;
    bool plausible(const ChannelFrame& frame, Instant now);
    bool within(const PulseRange& range, const ChannelFrame& frame);
    bool any_zero(const ChannelFrame& frame) const;
    void note_implausible(const ChannelFrame& frame, Instant now);
    void count_frame_lost(bool lost);
    bool too_many_lost() const;
    Instant not_after_frozen(Instant expiry) const;
    LinkState state_without_frames(Instant now) const;

    SupervisionSettings settings_;
    const DecoderReport* decoder_ = nullptr;
    ChannelFrame good_;
    ChannelFrame unchanged_;
    std::bitset<kRatioFrames> lost_marks_;
    std::size_t next_mark_ = 0;
    std::size_t lost_count_ = 0;
    std::uint64_t runs_ = 0;
    std::uint64_t run_frames_ = 0;  ///< good frames of the present run
    std::uint64_t absences_ = 0;
    ImplausibleFrames implausible_;

    /// When the good frame becomes too old if no other frame follows.
    Instant expires_{};
    Instant run_start_{};
    Instant lost_before_run_{};
    Instant radio_lost_since_{};
    Instant channels_missing_since_{};
    /// The frame with the reduced set of channels that the sender has used since `fewer_since_`.
    ChannelFrame fewer_;
    Instant fewer_since_{};
    Instant latest_frame_{};
    Instant kind_since_{};
    Instant unchanged_since_{};
    /// The channels that the latest frame lacked, one bit each, and masks for the others.
    std::uint32_t absent_ = kAllChannels;
    ChannelNumbers present_;
    /// Frames with a raw zero are not good until then.
    Instant guarded_until_{};
    Instant latest_bytes_{};
    Instant bytes_since_{};  ///< start of the bytes after the latest silence

    bool ever_good_ = false;
    /// Marked frames may keep the link alive although the good frame is older than the timeout.
    bool may_outlive_ = false;
    bool radio_lost_ = false;
    bool channels_missing_ = false;
    bool ever_frame_ = false;
    bool ever_bytes_ = false;
    /// The guard against raw zeros was started for the start or the present loss.
    bool guarded_ = false;
    Kind latest_kind_ = Kind::good;
    RadioLossSign sign_ = RadioLossSign::none;
};

}  // namespace tribus
