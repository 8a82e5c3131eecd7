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

/// What the main thread waits for: signals, an instant, and descriptors. Thread-bound to the main
/// thread.
class MainWait {
  public:
    /// From now on only `until` receives these signals. Call it before any thread is created,
    /// because threads inherit it. The error is a sentence.
    static tl::expected<MainWait, std::string> for_signals(std::initializer_list<int> signals);

    /// Waits until `deadline` or a signal, or until one of `others` is readable; -1 stands for
    /// none. Returns the signal, if there was one. If several are pending, it returns the one with
    /// the highest number: SIGTERM before SIGINT before SIGHUP.
    std::optional<int> until(Instant deadline, std::span<const int> others = {});
    /// Whether the latest wait found one of its `others` readable.
    bool other_readable() const { return other_readable_; }

  private:
    explicit MainWait(UniqueFd signals) : signals_(std::move(signals)) {}

    UniqueFd signals_;
    bool other_readable_ = false;
};

}  // namespace tribus
