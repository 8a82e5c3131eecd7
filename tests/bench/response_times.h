#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include <tl/expected.hpp>

#include "app/bench/distribution.h"
#include "core/time.h"
#include "tests/bench/bound.h"

/// How soon sensors answer a receiver: the product beside a responder that only waits, reads and
/// writes.
namespace tribus::test {

/// By then an answer was withheld. It counts as one that took so long.
constexpr Duration kNoAnswerAfter = std::chrono::microseconds(1800);
/// That the product waits of itself, when it is not told otherwise.
constexpr Duration kDefaultReplyAfter = std::chrono::microseconds(200);
/// The proven window of an answer (docs/protocols/ibus.md, "Sensor bus: answer times").
constexpr Duration kResponseWindow = std::chrono::milliseconds(1);

struct Responses {
    bench::Distribution times;  ///< from the end of the request to the beginning of the reply
    std::size_t missed = 0;     ///< of them: no answer
};

struct ResponseTimes {
    Responses at_once;     ///< of the product, told not to wait
    Responses by_default;  ///< of the product
    Responses bare;
    Responses bare_again;
};

/// Asks each of them over its own pty in every slot of `settings.length`; all run in real time.
tl::expected<ResponseTimes, std::string> response_times(const BoundSettings& settings);

}  // namespace tribus::test
