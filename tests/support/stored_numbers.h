#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>

#include "core/number_reservation.h"
#include "core/time.h"
#include "transports/codecs/authenticated/broadcast.h"

namespace tribus::test {

/// An epoch file without a disk. A test says when it is written, and when its program starts again.
class StoredNumbers final : public NumberReservation {
  public:
    explicit StoredNumbers(std::uint64_t number) : stored_(number) { start(Instant{}); }

    /// Forgets what was used but not stored, as after SIGKILL. A sender goes on by its clock.
    void start(Instant now) {
        begin(zero_ ? at(authenticated::clock_step(now)) : stored_);
        reserved_ = stored_;
        wanted_ = 0;
        for (auto& [id, numbers] : of_keys_) {
            numbers.start(now);
        }
    }
    NumberReservation& of_key(std::uint32_t id) override {
        return of_keys_.try_emplace(id, stored_).first->second;
    }
    /// The least number that was not used belongs to the first step that is asked for.
    std::uint64_t at(std::uint64_t step) override {
        zero_ = zero_.value_or(next() - step);
        return *zero_ + step;
    }
    void store() {
        stored_ = std::max(stored_, wanted_);
        reserved_ = stored_;
        for (auto& [id, numbers] : of_keys_) {
            numbers.store();
        }
    }
    /// The machine starts again or was suspended: what a sender has used is known, but not how much
    /// time has passed since.
    void lose_clock(Instant now) {
        stored_ = std::max(stored_, next()) + authenticated::kNewClockNumbers;
        zero_ = stored_ - authenticated::clock_step(now);
    }
    /// As an orderly end, after which nothing that was reserved is lost.
    void stop() {
        stored_ = next();
        for (auto& [id, numbers] : of_keys_) {
            numbers.stop();
        }
    }

  private:
    std::uint64_t reserved() const override { return reserved_; }
    void want(std::uint64_t end) override { wanted_ = end; }

    std::uint64_t stored_;
    std::uint64_t reserved_ = 0;
    std::uint64_t wanted_ = 0;
    std::optional<std::uint64_t> zero_{};
    std::map<std::uint32_t, StoredNumbers> of_keys_;
};

}  // namespace tribus::test
