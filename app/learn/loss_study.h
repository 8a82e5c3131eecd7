#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/learn/loss_rules.h"
#include "config/schema/schema.h"
#include "core/time.h"
#include "pipelines/rules/settings.h"

/// Studies how a receiver behaves when its transmitter is switched off, and which detectors
/// recognise it. Pure.
namespace tribus {

/// When the transmitter was switched.
struct LossStudyTimes {
    Instant off{};   ///< switched off
    Instant back{};  ///< switched on again
};

struct LossStudyResult {
    /// What the receiver did, in sentences.
    std::vector<std::string> findings;
    /// True if the detectors recognise the loss and give no false alarm.
    bool recognised = false;
    /// Settings of these detectors.
    SupervisionSettings supervision;
    /// Lines to add to [input.NAME]; none if the defaults suffice.
    std::vector<std::string> lines;
    /// What the user should know or do.
    std::vector<std::string> advice;
    /// From switching off to the loss, and from switching on to the return, as the detectors see
    /// them in these frames.
    std::optional<Duration> time_to_loss;
    std::optional<Duration> time_to_return;
};

/// Tries the detectors in order of safety: silence, flags, values, frozen values. Then plays the
/// frames through those that it chose. Keeps the supervision that `input` already has and uses it
/// if it recognises the loss.
LossStudyResult study_loss(const InputConfig& input, StudiedFrames frames,
                           const LossStudyTimes& times);

}  // namespace tribus
