#pragma once

#include <string>
#include <string_view>

#include "app/status/status.h"

namespace tribus {

/// All counters and measurements in the text format 0.0.4 of Prometheus. Each sample has the label
/// `daemon`. Pure.
/// Not made with the library prometheus-cpp: it keeps its own values behind locks, for many
/// counting threads, and is one more shared library to load. Here one thread has all figures
/// already.
std::string metrics_text(const StatusReport& report);

/// The value of a label as it stands between quotes.
std::string escaped_label(std::string_view text);

}  // namespace tribus
