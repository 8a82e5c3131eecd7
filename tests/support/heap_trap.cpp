#include "tests/support/heap_trap.h"

#include <cerrno>
#include <cstddef>
#include <cstdlib>

// Replaces the C library's malloc in the test program, for operator new and for C code.

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TRIBUS_HEAP_TRAP 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define TRIBUS_HEAP_TRAP 0
#endif
#endif
#ifndef TRIBUS_HEAP_TRAP
#define TRIBUS_HEAP_TRAP 1
#endif

namespace {

thread_local bool watching = false;
thread_local std::uint64_t allocations_seen = 0;

}  // namespace

#if TRIBUS_HEAP_TRAP
namespace {
void note() {
    allocations_seen += watching ? 1U : 0U;
}
}  // namespace

extern "C" {
// Entry points of the C library that its header does not declare.
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* block, std::size_t size);             // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) {
    note();
    return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
    note();
    return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
    note();
    return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    note();
    return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
    note();
    *block = __libc_memalign(alignment, size);
    return *block == nullptr ? ENOMEM : 0;
}
}
#endif

namespace tribus::test {

bool HeapTrap::works() {
    return TRIBUS_HEAP_TRAP != 0;
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
