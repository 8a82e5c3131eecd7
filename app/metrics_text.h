#pragma once

#include <string>

#include "app/status.h"

namespace tribus {

/// Everything that counts or can be measured, for Prometheus: text format 0.0.4. Pure.
///
/// Written here and not by the library prometheus-cpp: that keeps its own values behind locks, for
/// threads that all count, and is a shared library more to load; here one thread has all figures in
/// its hand already.
std::string metrics_text(const StatusReport& report);

}  // namespace tribus
