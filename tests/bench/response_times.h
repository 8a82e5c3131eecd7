#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include <tl/expected.hpp>

#include "core/distribution.h"
#include "core/time.h"
#include "tests/bench/bound.h"

/// Response times of sensors: the product compared with a bare responder that only waits, reads and
/// writes.
namespace tribus::test {

/// Time after which an answer counts as withheld. Such an answer is recorded with this time.
constexpr Duration kNoAnswerAfter = std::chrono::microseconds(1800);
/// Default time that the product waits before it answers.
constexpr Duration kDefaultReplyAfter = std::chrono::microseconds(200);
/// Proven time window of an answer (docs/protocols/ibus.md, "Sensor bus: answer times").
constexpr Duration kResponseWindow = std::chrono::milliseconds(1);

struct Responses {
    Distribution times;      ///< from the end of the request to the beginning of the reply
    std::size_t missed = 0;  ///< requests without an answer
};

struct ResponseTimes {
    Responses at_once;     ///< the product without a wait
    Responses by_default;  ///< the product with its default wait
    Responses bare;
    Responses bare_again;
};

/// Asks each responder over its own pty in every slot of `settings.length`. All run in real time.
tl::expected<ResponseTimes, std::string> response_times(const BoundSettings& settings);

}  // namespace tribus::test
