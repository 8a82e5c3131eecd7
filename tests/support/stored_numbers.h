#pragma once

#include <algorithm>
#include <cstdint>

#include "core/number_reservation.h"

namespace tribus::test {

/// An epoch file without a disk. A test says when it is written, and when its program starts again.
class StoredNumbers final : public NumberReservation {
  public:
    explicit StoredNumbers(std::uint64_t number) : stored_(number) { start(); }

    /// Forgets what was used but not stored, as after SIGKILL.
    void start() {
        begin(stored_);
        reserved_ = stored_;
        wanted_ = 0;
    }
    void store() {
        stored_ = std::max(stored_, wanted_);
        reserved_ = stored_;
    }
    /// As an orderly end, after which nothing that was reserved is lost.
    void stop() { stored_ = next(); }

  private:
    std::uint64_t reserved() const override { return reserved_; }
    void want(std::uint64_t end) override { wanted_ = end; }

    std::uint64_t stored_;
    std::uint64_t reserved_ = 0;
    std::uint64_t wanted_ = 0;
};

}  // namespace tribus::test
