#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipelines/engine/change.h"
#include "pipelines/realtime/snapshot.h"

namespace tribus {

/// The latest changes of one engine. The thread of the engine writes them and never waits; a reader
/// who comes too late finds the oldest ones overwritten. `add`: thread-bound to that thread. The
/// others: thread-safe. No allocation after construction.
class ChangeRing final : public ChangeSink {
  public:
    /// Twenty losses a second of an input and its output fill it in 3 s.
    static constexpr std::size_t kChanges = 256;

    ChangeRing() : changes_(kChanges) {}

    /// Gives the change its number.
    void add(Change change) override {
        change.number = newest_.load(std::memory_order_relaxed) + 1;
        changes_[change.number % kChanges].publish(change);
        newest_.store(change.number, std::memory_order_release);
    }
    /// Number of the newest change. 0: there was none.
    std::uint64_t newest() const { return newest_.load(std::memory_order_acquire); }
    /// The change of that number, at most `newest`. `nullopt`: it has been overwritten.
    std::optional<Change> read(std::uint64_t number) const {
        const Change change = changes_[number % kChanges].read();
        return change.number == number ? std::optional(change) : std::nullopt;
    }

  private:
    std::vector<Snapshot<Change>> changes_;
    std::atomic<std::uint64_t> newest_{0};
};

}  // namespace tribus
