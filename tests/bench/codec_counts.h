#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "tests/bench/codec_ceilings.h"

/// Instructions of the codecs, as two processors execute them: exact, the same on every machine,
/// and so fit to fail a test. What is counted, and how, tells README.md beside this file.
namespace tribus::bench {

enum class Machine : std::uint8_t { x86, arm };

/// Why this machine cannot count; empty if it can.
std::string missing(Machine machine);

/// Instructions a frame, or a byte of garbage, from the difference of a run over `from` units and
/// one over `to`. Nothing where a run fails.
std::optional<double> cost(Machine machine, const Row& row, std::size_t from, std::size_t to,
                           std::size_t prepared);
/// The same, with as many units as each machine needs for an exact figure.
std::optional<double> cost(Machine machine, const Row& row);

}  // namespace tribus::bench
