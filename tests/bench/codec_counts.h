#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "tests/bench/codec_ceilings.h"

/// Instructions that the codecs take on two processors. The counts are exact and the same on every
/// machine, so a test can compare them. README.md in this folder says what is counted and how.
namespace tribus::bench {

enum class Machine : std::uint8_t { x86, arm };

/// Returns why this machine cannot count, or an empty text if it can.
std::string missing(Machine machine);

/// Returns the instructions for a frame or a byte of garbage: the difference between a run over
/// `from` units and one over `to`. Returns nothing if a run fails.
std::optional<double> cost(Machine machine, const Row& row, std::size_t from, std::size_t to,
                           std::size_t prepared);
/// The same with as many units as the machine needs for an exact figure.
std::optional<double> cost(Machine machine, const Row& row);

/// System calls for a snapshot, of a row of the link. Returns nothing if a run fails.
std::optional<double> system_calls(const Row& row);

}  // namespace tribus::bench
