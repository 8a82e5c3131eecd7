#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/time.h"
#include "pipelines/settings.h"

namespace tribus {

/// What is known of a link at an instant.
struct LinkState {
    LinkCause cause = LinkCause::never_seen;
    RadioLossSign sign = RadioLossSign::none;
    /// Since when it is so; nothing to say of a link that was never seen.
    Instant since{};
};

/// Judges whether the frames of one input count, and why not: by what the sender says, by values
/// that mean loss, by silence, by frames that stand still or cannot be. Pure; thread-bound; no
/// allocation after construction.
class LinkSupervisor {
  public:
    explicit LinkSupervisor(SupervisionSettings settings);

    /// Goes on at `now` with all that `before` knows, which is left empty; judges by its own
    /// settings. A timeout that was shortened counts at once, one that was prolonged from the next
    /// good frame on.
    void continue_from(LinkSupervisor& before, Instant now);

    /// Bytes came, whether or not a frame will come of them.
    void bytes_came(Instant now);
    /// Nobody looked from `since` to `now`; what came meanwhile was told already. For as long as
    /// the timeout or longer: lost since then, and of no use to an output that still holds values
    /// until it has proved itself anew.
    void was_away(Instant since, Instant now);
    /// How often it was lost so.
    std::uint64_t absences() const { return absences_; }
    Duration timeout() const { return settings_.timeout; }
    /// A whole frame came at `now`. What is ignored, or found by a rule, is set right in its flags.
    void take(ChannelFrame& frame, Instant now);

    /// Whether its frames count at `at`, which may lie a little ahead.
    bool alive(Instant at) const {
        return ever_good_ && !radio_lost_ && !channels_missing_ && at < expires_;
    }
    /// When it was lost, or will be if nothing more comes. Only where it was ever good. A sender
    /// that says failsafe after the timeout tells nothing new.
    Instant lost_at() const {
        const Instant radio = radio_lost_ ? radio_lost_since_ : expires_;
        const Instant channels = channels_missing_ ? channels_missing_since_ : expires_;
        return std::min({radio, channels, expires_});
    }
    bool ever_good() const { return ever_good_; }
    /// Start of the unbroken run of good frames.
    Instant run_start() const { return run_start_; }
    /// The run is the first one: it was never lost, so there is nothing to recover from.
    bool first_run() const { return runs_ <= 1; }
    /// The values of the latest good frame, marked frame-lost if a newer frame was not good.
    const ChannelFrame& control() const { return good_; }

    /// At `now`, which is not before what was told already.
    LinkState state(Instant now) const;

  private:
    enum class Kind : std::uint8_t { good, frame_lost, radio_lost, implausible, channels_missing };
    struct Verdict {
        Kind kind = Kind::good;
        RadioLossSign sign = RadioLossSign::none;
    };

    void watch_for_change(const ChannelFrame& frame, Instant now);
    Verdict judge(const ChannelFrame& frame, Instant now);
    void accept(const ChannelFrame& frame, Instant now);
    bool channels_missing(const ChannelFrame& frame, Instant now);
    void refuse(Verdict verdict, Instant now);
    bool rule_says_loss(const ChannelFrame& frame) const;
    bool all_zero(const ChannelFrame& frame) const;
    bool plausible(const ChannelFrame& frame, Instant now);
    bool any_zero(const ChannelFrame& frame) const;
    void count_frame_lost(bool lost);
    bool too_many_lost() const;
    Instant not_after_frozen(Instant expiry) const;
    LinkState state_without_frames(Instant now) const;

    static constexpr std::size_t kRatioFrames = 100;

    SupervisionSettings settings_;
    ChannelFrame good_;
    ChannelFrame unchanged_;
    std::bitset<kRatioFrames> lost_marks_;
    std::size_t next_mark_ = 0;
    std::size_t lost_count_ = 0;
    std::uint64_t runs_ = 0;
    std::uint64_t absences_ = 0;

    /// When the good frame becomes too old, if nothing else comes.
    Instant expires_{};
    Instant run_start_{};
    Instant lost_before_run_{};
    Instant radio_lost_since_{};
    Instant channels_missing_since_{};
    /// The frame whose channels the sender has left since then, and no more than those.
    ChannelFrame fewer_;
    Instant fewer_since_{};
    Instant latest_frame_{};
    Instant kind_since_{};
    Instant unchanged_since_{};
    /// A raw zero does not count until then.
    Instant guarded_until_{};
    Instant latest_bytes_{};
    Instant bytes_since_{};  ///< after the latest silence

    bool ever_good_ = false;
    bool run_broken_ = true;
    bool radio_lost_ = false;
    bool channels_missing_ = false;
    bool ever_frame_ = false;
    bool ever_bytes_ = false;
    /// The guard against raw zeros was set up for the start or the present loss.
    bool guarded_ = false;
    Kind latest_kind_ = Kind::good;
    RadioLossSign sign_ = RadioLossSign::none;
};

}  // namespace tribus
