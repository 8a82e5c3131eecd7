#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/time.h"

namespace tribus::bench {

/// What `--require` asks of the latency.
struct Requirement {
    std::string text;  ///< as it was written
    double percent = 0;
    bool added = false;  ///< over the bare relay's, instead of the whole
    Duration most{};
};

/// "p99=200us", "added-p50=20us": p50, p90 or p99, and a duration. The error says what is allowed.
tl::expected<Requirement, std::string> parse_requirement(std::string_view text);

/// A sentence where the measured percentiles, the daemon's and the bare relay's, break it.
std::optional<std::string> broken(const Requirement& requirement, Duration whole, Duration bare);

/// "850ns", "42us", "3.51ms", "1.2s": three digits of it.
std::string short_time(Duration duration);

}  // namespace tribus::bench
