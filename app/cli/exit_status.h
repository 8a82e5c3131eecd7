#pragma once

/// Exit statuses of the program.
namespace tribus {

inline constexpr int kExitFine = 0;
/// The work failed: a device, a bus, a file.
inline constexpr int kExitFailed = 1;
/// Wrong use, or a wrong configuration.
inline constexpr int kExitWrongUse = 2;
/// Interrupted by Ctrl-C before there was a result.
inline constexpr int kExitInterrupted = 130;

}  // namespace tribus
