#include "tests/support/heap_trap.h"

#include <cstdint>

#include "tests/support/every_allocation.h"

namespace tribus::test {
namespace {

thread_local bool watching = false;
thread_local std::uint64_t allocations_seen = 0;

}  // namespace

void on_allocation() {
    allocations_seen += watching ? 1U : 0U;
}

HeapTrap::HeapTrap() {
    allocations_seen = 0;
    watching = true;
}
HeapTrap::~HeapTrap() {
    watching = false;
}

std::uint64_t HeapTrap::allocations() const {
    return allocations_seen;
}

}  // namespace tribus::test
