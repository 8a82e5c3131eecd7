#pragma once

/// Replaces the C library's malloc and its like in a program or module, for operator new and for C
/// code.
namespace tribus::test {

/// Each call of malloc and its like calls this, which the program or module defines.
void on_allocation();

/// Returns whether they are replaced: not in a build with a sanitizer, which replaces them itself.
bool every_allocation_is_seen();

}  // namespace tribus::test
