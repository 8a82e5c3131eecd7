#pragma once

#include <cstdint>

namespace tribus::test {

/// Counts the allocations of the calling thread for as long as it lives. One at a time.
class HeapTrap {
  public:
    /// Whether this build can watch the heap: a sanitizer replaces malloc by its own.
    static bool works();

    HeapTrap();
    HeapTrap(const HeapTrap&) = delete;
    HeapTrap& operator=(const HeapTrap&) = delete;
    ~HeapTrap();
    std::uint64_t allocations() const;
};

}  // namespace tribus::test
