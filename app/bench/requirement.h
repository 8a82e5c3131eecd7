#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/time.h"

namespace tribus::bench {

/// A requirement of `--require` on the latency.
struct Requirement {
    std::string text;  ///< as given
    double percent = 0;
    bool added = false;  ///< compare the difference to the bare relay, not the whole latency
    Duration most{};
};

/// Parses "p99=200us" or "added-p50=20us": p50, p90 or p99, and a duration. The error says what is
/// allowed.
tl::expected<Requirement, std::string> parse_requirement(std::string_view text);

/// A sentence if the measured percentiles of tribus (`whole`) and the bare relay break the
/// requirement.
std::optional<std::string> broken(const Requirement& requirement, Duration whole, Duration bare);

/// "850ns", "42us", "3.51ms", "1.2s": at most three digits.
std::string short_time(Duration duration);

}  // namespace tribus::bench
