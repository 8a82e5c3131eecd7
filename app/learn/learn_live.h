#pragma once

#include <cstddef>
#include <cstdint>
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

/// How the person is told what to do.
enum class LearnGuide : std::uint8_t {
    terminal,  ///< lines on standard error; standard input must be a terminal
    json,      ///< `{"step","text"}` in a line of standard output before each answer
    alone,     ///< lines on standard error; nobody answers. Only of a gamepad
};

/// Opens the device of one input and guides a person through switching the transmitter off and on.
/// A line on standard input says that it is done. The error is a sentence.
tl::expected<LearnedFrames, std::string> watch_with_a_person(const Configuration& configuration,
                                                             std::size_t input, LearnGuide guide);

}  // namespace tribus
