#pragma once

#include <cstdint>

namespace tribus::test {

/// Counts the allocations of the calling thread during the object's lifetime. One object at a time.
class HeapTrap {
  public:
    /// Returns whether this build can watch the heap: with a sanitizer it cannot, which replaces
    /// malloc.
    static bool works();

    HeapTrap();
    HeapTrap(const HeapTrap&) = delete;
    HeapTrap& operator=(const HeapTrap&) = delete;
    ~HeapTrap();
    std::uint64_t allocations() const;
};

}  // namespace tribus::test
