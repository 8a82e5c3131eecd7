#pragma once

#include <optional>
#include <utility>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/rules/link_supervisor.h"
#include "pipelines/rules/settings.h"

namespace tribus {

/// Result of an input's loss detection for a recorded frame.
struct JudgedFrame {
    LinkState state;
    /// The state just before this frame, if the link was lost then.
    std::optional<LinkState> lost_before;
    ImplausibleFrames implausible{};
};

/// Runs the loss detection of an input over a recording. Without settings or without times it
/// returns nothing.
class FrameJudge {
  public:
    explicit FrameJudge(const std::optional<SupervisionSettings>& settings) {
        if (settings) {
            supervisor_.emplace(*settings);
        }
    }

    /// Call it before the frames that these bytes complete.
    void bytes_came(std::optional<Duration> at) {
        if (!supervisor_ || !at) {
            return;
        }
        const Instant now(*at);
        if (was_good_ && !supervisor_->alive(now)) {
            lost_before_ = supervisor_->state(now);
        }
        supervisor_->bytes_came(now);
    }
    /// Judges one frame that starts `at`.
    std::optional<JudgedFrame> judge(ChannelFrame frame, std::optional<Duration> at) {
        if (!supervisor_ || !at) {
            return std::nullopt;
        }
        const Instant now(*at);
        frame.received = now;
        supervisor_->take(frame, now);
        was_good_ = supervisor_->alive(now);
        return JudgedFrame{.state = supervisor_->state(now),
                           .lost_before = std::exchange(lost_before_, std::nullopt),
                           .implausible = supervisor_->implausible()};
    }

  private:
    std::optional<LinkSupervisor> supervisor_;
    bool was_good_ = false;
    std::optional<LinkState> lost_before_;
};

}  // namespace tribus
