#pragma once

#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "app/bench/distribution.h"
#include "core/time.h"

namespace tribus::bench {

/// Time from writing an i.Bus frame at one real port to having its values behind another port,
/// connected by a wire. All figures include the time on the wire.
struct PortsResult {
    Distribution engine;  ///< until the data thread of tribus writes the translated frame
    Distribution bare;    ///< until a thread that only waits and reads has the last byte
    Distribution bare_again;
};

/// Writes on `out` and reads on `in`: first the bare reader, then tribus, then the bare reader
/// again, each for a third of `length`. The error is a sentence.
tl::expected<PortsResult, std::string> measure_ports(const std::string& in, const std::string& out,
                                                     std::optional<int> priority, Duration length);

}  // namespace tribus::bench
