#pragma once

#include <string>

#include "app/status/status.h"

namespace tribus {

/// All counters and measurements in the text format 0.0.4 of Prometheus. Pure.
/// Not made with the library prometheus-cpp: it keeps its own values behind locks, for many
/// counting threads, and is one more shared library to load. Here one thread has all figures
/// already.
std::string metrics_text(const StatusReport& report);

}  // namespace tribus
