#pragma once

namespace tribus {

/// Locks into memory what the data path may touch: what it has made, its stacks and data, the code
/// of the layers that carry frames, and the C library. What only the start needed is given back; it
/// comes again page by page when something else runs it, and stays then. Where the program was
/// linked without `data_path.ld`, everything is locked.
///
/// Call when all that runs has been made, before it runs; again after more was made. Returns 0, or
/// the error number of what the kernel refused.
[[nodiscard]] int lock_memory();

}  // namespace tribus
