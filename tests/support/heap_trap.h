#pragma once

#include <cstdint>

namespace tribus::test {

/// Whether this build can watch the heap: a sanitizer replaces malloc by its own.
bool heap_trap_works();

/// Counts the allocations of the calling thread for as long as it lives. One at a time.
class HeapTrap {
  public:
    HeapTrap();
    HeapTrap(const HeapTrap&) = delete;
    HeapTrap& operator=(const HeapTrap&) = delete;
    ~HeapTrap();
    std::uint64_t allocations() const;
};

}  // namespace tribus::test
