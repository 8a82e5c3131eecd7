#pragma once

#include "core/time.h"

namespace tribus {

/// The machine's monotonic clock. The only place in the project that reads a clock. Thread-safe.
Instant monotonic_now();

}  // namespace tribus
