#pragma once

namespace tribus {

/// Locks into memory what the data path may touch: what it has made, its stacks and data, the code
/// of the layers that carry frames, and the C library. What only the start needed is given back; it
/// comes again page by page when something else runs it, and stays then. Where the program was
/// linked without `data_path.ld`, everything is locked.
///
/// Where RLIMIT_MEMLOCK binds this process, that alone is locked, as much of it as the limit lets
/// through: memory that comes later is not, so that neither a thread's stack nor the heap meets the
/// limit.
///
/// Call when all that runs has been made, before it runs. Returns 0, or the error number of what
/// the kernel refused first; the rest is locked all the same.
[[nodiscard]] int lock_memory();

/// Locks what has been made since `lock_memory`, where a limit kept it from being locked by itself.
/// Any thread. Returns as `lock_memory` does.
[[nodiscard]] int lock_new_memory();

}  // namespace tribus
