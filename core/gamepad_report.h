#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// The state of a gamepad as bytes, which a link makes of the kernel's events
/// (docs/protocols/gamepad.md, "Report"). Numbers have the low byte first.
namespace tribus::gamepad_report {

inline constexpr std::uint8_t kMagic = 0x67;
inline constexpr std::size_t kReportFlagsAt = 1;
inline constexpr std::size_t kAxisCountAt = 2;
inline constexpr std::size_t kButtonCountAt = 3;
inline constexpr std::size_t kHeaderBytes = 4;
/// The code of an axis, and its position.
inline constexpr std::size_t kAxisBytes = 3;
/// The code of a pressed button.
inline constexpr std::size_t kButtonBytes = 2;
inline constexpr std::size_t kMostAxes = 16;
inline constexpr std::size_t kMostButtons = 32;
inline constexpr std::size_t kMostBytes =
    kHeaderBytes + kAxisBytes * kMostAxes + kButtonBytes * kMostButtons;

/// The device is gone. The last report.
inline constexpr std::uint8_t kGone = 1;
/// Something changed since the report before.
inline constexpr std::uint8_t kChanged = 2;

/// The ends of an axis. The centre is 0.
inline constexpr int kFullDeflection = 32767;

}  // namespace tribus::gamepad_report
