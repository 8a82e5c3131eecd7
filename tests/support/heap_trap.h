#pragma once

#include <cstdint>

namespace tribus::test {

/// Counts the allocations of the calling thread during the object's lifetime. One object at a time.
/// It sees none where kSanitized is set (tests/support/sanitized.h).
class HeapTrap {
  public:
    HeapTrap();
    HeapTrap(const HeapTrap&) = delete;
    HeapTrap& operator=(const HeapTrap&) = delete;
    ~HeapTrap();
    std::uint64_t allocations() const;
};

}  // namespace tribus::test
