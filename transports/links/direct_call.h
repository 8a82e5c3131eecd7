#pragma once

#include <sys/syscall.h>
#include <unistd.h>

#include <cstddef>

/// System calls of the data path. The C library's own functions are cancellation points: in a
/// program with threads, each call passes two more functions, which take longer than the rest of
/// it. Nothing here is ever cancelled. Thread-safe.
namespace tribus {

/// As ::read: the number of bytes, or -1 with errno.
inline ssize_t read_directly(int descriptor, void* bytes, std::size_t size) {
    return ::syscall(SYS_read, descriptor, bytes, size);
}
/// As ::write.
inline ssize_t write_directly(int descriptor, const void* bytes, std::size_t size) {
    return ::syscall(SYS_write, descriptor, bytes, size);
}

}  // namespace tribus
