#pragma once

#include <sched.h>

#include <string>
#include <vector>

#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus::bench {

/// Keeps the processors awake for as long as it lives, where that is permitted: a sleeping one
/// takes several times as long to answer, and that is none of what is measured.
class AwakeProcessors {
  public:
    AwakeProcessors();
    bool held() const { return request_.valid(); }

  private:
    UniqueFd request_;
};

/// The calling thread as a tester, for as long as it lives: SCHED_FIFO above all that it measures,
/// on CPU 0 where there are more, its memory locked. What is not permitted is left out. Processes
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

/// The calling thread may have SCHED_FIFO at `priority` and locked memory.
bool realtime_permitted(int priority);

int processor_count();

/// Sleeps until `instant`, on the clock of `monotonic_now`; less where a signal comes.
void sleep_until(Instant instant);

/// From here on Ctrl-C and SIGTERM only set what `interrupted` says.
void watch_for_interruption();
bool interrupted();

}  // namespace tribus::bench
