#pragma once

#include <sched.h>

#include <string>
#include <vector>

#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus::bench {

/// Keeps the processors awake while it lives, if permitted: a sleeping processor answers several
/// times slower, which is not what is measured.
class AwakeProcessors {
  public:
    AwakeProcessors();
    /// False if it is not permitted.
    bool held() const { return request_.valid(); }

  private:
    UniqueFd request_;
};

/// Makes the calling thread a tester while it lives: SCHED_FIFO above everything that it measures,
/// on CPU 0 if there are several, with locked memory. Skips what is not permitted. Processes
/// started meanwhile do not inherit the priority.
class TesterPriority {
  public:
    TesterPriority();
    TesterPriority(const TesterPriority&) = delete;
    TesterPriority& operator=(const TesterPriority&) = delete;
    ~TesterPriority();

  private:
    cpu_set_t old_cpus_{};
    int old_policy_ = SCHED_OTHER;
    sched_param old_parameters_{};
    bool locked_ = false;
};

int processor_count();

/// Sleeps until `instant`, on the clock of `monotonic_now`; a signal ends it early.
void sleep_until(Instant instant);

/// From now on Ctrl-C and SIGTERM only make `interrupted` true.
void watch_for_interruption();
/// True after the first such signal.
bool interrupted();

}  // namespace tribus::bench
