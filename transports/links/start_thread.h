#pragma once

#include <pthread.h>

#include <cstddef>
#include <cstdint>

namespace tribus {

enum class ThreadKind : std::uint8_t { joined, detached };

/// Starts a thread that runs `main(argument)`. All of a stack may be locked into memory, so it is
/// small: `stack_bytes`, beside what the C library keeps on it (thread-local storage). Returns 0,
/// or an error number; then there is no thread. Thread-safe.
[[nodiscard]] int start_thread(pthread_t& thread, std::size_t stack_bytes, void* (*main)(void*),
                               void* argument, ThreadKind kind = ThreadKind::joined);

/// From now on each other thread, such as a std::thread, gets such a stack too. Returns 0, or an
/// error number; then it gets what the system gives, usually 8 MiB. Before any thread starts.
[[nodiscard]] int set_usual_stack(std::size_t stack_bytes);

}  // namespace tribus
