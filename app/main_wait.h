#pragma once

#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// All that the main thread waits for: signals, an instant, and descriptors of those who want
/// something. Thread-bound to the main thread.
class MainWait {
  public:
    /// From here on these signals come by `until` only. Call it before any other thread is made,
    /// which inherits that. The error is a sentence.
    static tl::expected<MainWait, std::string> for_signals(std::initializer_list<int> signals);

    /// Waits until `deadline` at most, and no longer than until something can be read from one of
    /// `others`; -1 is none. The signal that ended it, if one did; of several at once that with the
    /// highest number: SIGTERM before SIGINT before SIGHUP, however often that one comes.
    std::optional<int> until(Instant deadline, std::span<const int> others = {});

  private:
    explicit MainWait(UniqueFd signals) : signals_(std::move(signals)) {}

    UniqueFd signals_;
};

}  // namespace tribus
