#pragma once

#include <algorithm>
#include <chrono>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "app/doctor/listening/line_heard.h"
#include "app/doctor/listening/line_judge.h"
#include "app/doctor/listening/listener.h"
#include "tests/support/uart_wire.h"
#include "transports/recordings/recording.h"

/// Recordings of real receivers, or their twins, replayed on a simulated wire and read by simulated
/// ports.
namespace tribus::test {

struct SentAs {
    SenderLine sender;
    /// Idle bits between two bytes: genuine FlySky devices leave one.
    unsigned pause_bits = 0;
};

/// Enough time to identify a protocol.
inline constexpr Duration kRecordedTime = std::chrono::milliseconds(400);

/// Puts the first `kRecordedTime` of a recording on a wire.
inline Wire on_a_wire(const Recording& recording, const SentAs& as) {
    Wire wire(as.sender);
    for (const Burst& burst : recording.bursts) {
        if (*burst.start < kRecordedTime) {
            wire.send(*burst.start, burst.bytes, as.pause_bits);
        }
    }
    return wire;
}

struct HeardBy {
    UartKind kind = UartKind::waits_for_idle;
    Duration lump{1};  ///< the port delivers what came in such a time in one read
};

/// Ports of both kinds that deliver each byte, or once a millisecond what has come.
namespace heard_by {
inline constexpr HeardBy kEachByteWaitingForIdle{UartKind::waits_for_idle, Duration(1)};
inline constexpr HeardBy kLumpsWaitingForIdle{UartKind::waits_for_idle,
                                              std::chrono::milliseconds(1)};
inline constexpr HeardBy kEachByteAtOnce{UartKind::takes_error_for_start, Duration(1)};
inline constexpr HeardBy kLumpsAtOnce{UartKind::takes_error_for_start,
                                      std::chrono::milliseconds(1)};
}  // namespace heard_by

inline void expect_period(const doctor::LineStory& story, Duration expected) {
    ASSERT_TRUE(story.period);
    EXPECT_LT(std::chrono::abs(*story.period - expected), std::chrono::microseconds(100))
        << story.period->count();
}

/// Returns what doctor receives with each line setting, one after the other.
inline std::vector<doctor::Heard> heard_of(const Wire& wire, const HeardBy& by) {
    std::vector<doctor::Heard> all;
    std::vector<LineSettings> lines = doctor::usual_lines();
    std::ranges::copy(doctor::further_lines(), std::back_inserter(lines));
    for (const LineSettings& line : lines) {
        all.push_back({.line = line,
                       .listened = kRecordedTime,
                       .bursts = in_lumps(UartEar(line, by.kind).listen(wire), by.lump)});
    }
    return all;
}

}  // namespace tribus::test
