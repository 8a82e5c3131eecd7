#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "app/main_wait.h"
#include "core/time.h"
#include "transports/links/recording.h"

/// Where `replay` sends a recording to.
namespace tribus {

/// One burst of bytes or one CAN frame.
struct ReplayItem {
    Duration at{};  ///< from the start
    const Burst* burst = nullptr;
    const CanFrame* frame = nullptr;
};

enum class ReplayOutcome : std::uint8_t {
    sent,
    refused,  ///< the port had no room, or nobody reads there
    gone,
};

/// Thread-bound.
class ReplayTarget {
  public:
    virtual ~ReplayTarget() = default;
    /// Waits until somebody can hear; false where a signal came first.
    virtual bool wait_for_reader(MainWait&) { return true; }
    virtual ReplayOutcome send(const ReplayItem& item) = 0;
    /// Called while nothing is to be sent; returns when to be called again at the latest.
    virtual Instant idle(Instant) { return kNever; }
};

struct ReplayPlace {
    std::string to;  ///< "pty", a path, or an interface
    std::string protocol;
    std::string baud;
    std::string link;  ///< for a pty: a path that is to lead to it; may be empty
};

inline constexpr std::string_view kNewPty = "pty";

/// Whether such a recording can go there. The error is for the person who asked.
tl::expected<void, std::string> check_replay_place(const ReplayPlace& place,
                                                   const Recording& recording);

/// Prints the name of a new pseudo-terminal. The error is for the person who asked.
tl::expected<std::unique_ptr<ReplayTarget>, std::string> open_replay_target(
    const ReplayPlace& place, const Recording& recording);

}  // namespace tribus
