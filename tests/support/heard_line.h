#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <vector>

#include "app/doctor/listening/line_judge.h"
#include "tests/support/streams.h"
#include "transports/codecs/protocol.h"

namespace tribus::test {

/// Returns how doctor judges a second on the protocol's line, on which `bursts` come by turns, one
/// each `period`.
inline doctor::LineStory story_of(const Protocol& protocol, const std::vector<Bytes>& bursts,
                                  Duration period) {
    constexpr Duration kListened = std::chrono::seconds(1);
    doctor::Heard heard{.line = protocol.line, .listened = kListened, .bursts = {}};
    for (Duration start{}; start < kListened; start += period) {
        const Bytes& bytes = bursts[heard.bursts.size() % bursts.size()];
        heard.bursts.push_back(
            {.start = start, .bytes = bytes, .damaged = std::vector<bool>(bytes.size())});
    }
    return doctor::judge_line(std::span(&heard, 1));
}

}  // namespace tribus::test
