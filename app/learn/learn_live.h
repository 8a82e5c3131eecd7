#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/learn/loss_study.h"
#include "config/schema/schema.h"

namespace tribus {

/// Frames of a receiver, and when a person switched the transmitter.
struct LearnedFrames {
    std::vector<StudiedFrame> frames;
    LossStudyTimes times;
};

/// Opens the device of one input and guides a person through switching the transmitter off and on.
/// Uses standard error and standard input, which must be a terminal. The error is a sentence.
tl::expected<LearnedFrames, std::string> watch_with_a_person(const Configuration& configuration,
                                                             std::size_t input);

}  // namespace tribus
