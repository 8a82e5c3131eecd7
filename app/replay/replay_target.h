#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "app/cli/main_wait.h"
#include "core/time.h"
#include "transports/recordings/recording.h"

/// Destinations of `replay`.
namespace tribus {

/// One burst of bytes or one CAN frame.
struct ReplayItem {
    Duration at{};  ///< since the start
    const Burst* burst = nullptr;
    const CanFrame* frame = nullptr;
};

enum class ReplayOutcome : std::uint8_t {
    sent,
    refused,  ///< the port had no room, or nobody reads
    gone,
};

/// A destination of `replay`. Thread-bound.
class ReplayTarget {
  public:
    virtual ~ReplayTarget() = default;
    /// Waits until somebody reads; returns false if a signal came first, or nobody can know of it.
    virtual bool wait_for_reader(MainWait&) { return true; }
    /// Sends one item now.
    virtual ReplayOutcome send(const ReplayItem& item) = 0;
    /// Called while there is nothing to send; returns when it must be called again.
    virtual Instant idle(Instant) { return kNever; }
};

/// The options of `replay` about its destination.
struct ReplayPlace {
    std::string to;  ///< "pty", a path, or an interface name
    std::string protocol;
    std::string baud;
    std::string link;  ///< for a pty: path of a symbolic link to it; may be empty
};

inline constexpr std::string_view kNewPty = "pty";

/// Checks whether the recording can be sent there. The error is written for the user.
tl::expected<void, std::string> check_replay_place(const ReplayPlace& place,
                                                   const Recording& recording);

/// Opens the destination and prints the name of a new pseudo-terminal. The error is written for the
/// user.
tl::expected<std::unique_ptr<ReplayTarget>, std::string> open_replay_target(
    const ReplayPlace& place, const Recording& recording);

}  // namespace tribus
