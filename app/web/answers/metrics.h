#pragma once

#include <optional>
#include <string>
#include <vector>

/// Metrics of all daemons in one text (docs/status.md, "Metrics"). Pure.
namespace tribus::web {

/// The text of a daemon; nothing if it did not answer in time.
struct DaemonMetrics {
    std::string name;
    std::optional<std::string> text;
};

/// In the text format 0.0.4 of Prometheus, in which the samples of a family stand together. Begins
/// with a family that says which daemons answered.
std::string metrics_of_all(const std::vector<DaemonMetrics>& daemons);

}  // namespace tribus::web
