#pragma once

#include <string>

#include "core/time.h"

namespace tribus {

/// A stretch of the machine's clock in which it tells exactly how much time passed: from a start of
/// the machine, or the end of a suspend, to the next one. How long a suspend took, the clock knows
/// to a second at best.
struct ClockRun {
    /// The start of the machine, the time namespace, the number of suspends. Without blanks. Empty:
    /// the kernel does not tell.
    std::string name;
    Duration asleep{};  ///< suspended since the machine started, by its clock

    bool is_same(const ClockRun& other) const;
};

/// That of now. Reads a file of the kernel: not for the data path. Main thread.
ClockRun clock_run();

}  // namespace tribus
