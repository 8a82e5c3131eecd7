#include "tests/support/every_allocation.h"

#include <cerrno>
#include <cstddef>
#include <cstdlib>

#ifndef TRIBUS_SANITIZED
extern "C" {
// Entry points of the C library that its header does not declare.
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* block, std::size_t size);             // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) {
    tribus::test::on_allocation();
    return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
    tribus::test::on_allocation();
    return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
    tribus::test::on_allocation();
    return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    tribus::test::on_allocation();
    return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
    tribus::test::on_allocation();
    *block = __libc_memalign(alignment, size);
    return *block == nullptr ? ENOMEM : 0;
}
}
#endif
