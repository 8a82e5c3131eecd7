#pragma once

#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "app/bench/distribution.h"
#include "core/time.h"

namespace tribus::bench {

/// From the write of an i.Bus frame at one real port to its values at hand behind another, which a
/// wire joins to it: the time on the wire is in all of them.
struct PortsResult {
    Distribution engine;  ///< to the write of the translated frame, by the product's data thread
    Distribution bare;    ///< to the read of the last byte, by a thread that only waits and reads
    Distribution bare_again;
};

/// Writes on `out`, reads on `in`: the bare reader, the product, the bare reader again, each for a
/// third of `length`. The error is a sentence.
tl::expected<PortsResult, std::string> measure_ports(const std::string& in, const std::string& out,
                                                     std::optional<int> priority, Duration length);

}  // namespace tribus::bench
