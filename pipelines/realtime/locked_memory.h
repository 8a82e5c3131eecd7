#pragma once

namespace tribus {

/// Locks into memory what the data path may touch: the heap, stacks and data of the process, the
/// code of the layers that carry frames, and the C library. Code that only the start needed is
/// dropped; each page comes back and stays when it is used again. Without `data_path.ld` in the
/// link, everything is locked.
///
/// Where RLIMIT_MEMLOCK limits this process, it locks that much and does not lock memory that is
/// allocated later, so that neither a stack nor the heap runs into the limit.
///
/// Call after everything that runs was created, before it runs. Returns 0, or the first error
/// number from the kernel; it locks the rest all the same.
[[nodiscard]] int lock_memory();

/// Locks what was allocated since `lock_memory`, if the limit kept that from being locked
/// automatically. Any thread. Returns as `lock_memory` does.
[[nodiscard]] int lock_new_memory();

}  // namespace tribus
