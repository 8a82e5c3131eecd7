#pragma once

/// Replaces the C library's malloc and its like in a program or module, for operator new and for C
/// code; not where kSanitized is set (tests/support/sanitized.h).
namespace tribus::test {

/// Each call of malloc and its like calls this, which the program or module defines.
void on_allocation();

}  // namespace tribus::test
