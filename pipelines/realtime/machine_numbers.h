#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "core/time.h"
#include "pipelines/engine/machine_facts.h"

namespace tribus {

/// Facts of the machine. The main thread writes them, the data thread reads them. Thread-safe.
/// Wait-free.
class MachineNumbers {
  public:
    MachineNumbers() {
        for (auto& number : numbers_) {
            number.store(kNone, std::memory_order_relaxed);
        }
    }
    /// Sets all facts, in the order of kMachineFacts, measured at `now`. Main thread.
    void set(std::span<const std::optional<double>, kMachineFactCount> numbers, Instant now) {
        for (std::size_t fact = 0; fact < numbers.size(); ++fact) {
            numbers_[fact].store(numbers[fact].value_or(kNone), std::memory_order_relaxed);
        }
        measured_at_ns_.store(now.time_since_epoch().count(), std::memory_order_release);
    }
    /// When they were set. If the main thread hangs, they must not look fresh.
    Instant measured_at() const {
        return Instant(Duration(measured_at_ns_.load(std::memory_order_acquire)));
    }
    /// The fact with that index in kMachineFacts. `nullopt` if the machine does not report it.
    std::optional<double> number(std::size_t fact) const {
        const double latest = numbers_[fact].load(std::memory_order_acquire);
        return std::isnan(latest) ? std::nullopt : std::optional(latest);
    }

  private:
    static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    static_assert(std::atomic<double>::is_always_lock_free);

    std::atomic<std::int64_t> measured_at_ns_{0};
    alignas(8) std::array<std::atomic<double>, kMachineFactCount> numbers_;
};

}  // namespace tribus
