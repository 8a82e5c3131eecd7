#pragma once

#include <array>
#include <cstdint>

namespace tribus {

/// Random bytes for what nobody may guess or meet twice. From the kernel, another one for each use;
/// zeros where nothing depends on it, as in a simulation.
using RandomSeed = std::array<std::uint8_t, 16>;
/// Makes another one at each call. Any thread.
using RandomSource = RandomSeed (*)();

}  // namespace tribus
