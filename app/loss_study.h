#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/loss_rules.h"
#include "config/schema.h"
#include "core/time.h"
#include "pipelines/settings.h"

/// How a receiver behaves when its transmitter is switched off, and which detectors tell. Pure.
namespace tribus {

/// When the person did what.
struct LossStudyTimes {
    Instant off{};   ///< the transmitter was switched off
    Instant back{};  ///< and on again
};

struct LossStudyResult {
    /// What the receiver did, in sentences.
    std::vector<std::string> findings;
    /// The detectors tell its loss, and no good frame was taken for one.
    bool recognised = false;
    /// With which detectors.
    SupervisionSettings supervision;
    /// The lines to put into [input.NAME]; none where the defaults do.
    std::vector<std::string> lines;
    /// What the person should know or do.
    std::vector<std::string> advice;
    /// From the switch to the loss, and back: as the detectors see it in these frames.
    std::optional<Duration> time_to_loss;
    std::optional<Duration> time_to_return;
};

/// Tries the detectors from the safest on: silence, the sender's flags, values, standing still; and
/// plays the frames through those that were found. `input` tells protocol and settings; what it
/// supervises already stays, and is used where it tells the loss.
LossStudyResult study_loss(const InputConfig& input, StudiedFrames frames,
                           const LossStudyTimes& times);

}  // namespace tribus
