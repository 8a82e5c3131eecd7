#pragma once

namespace tribus::test {

/// Whether the product has a sanitizer (CMakePresets.json): it replaces malloc, keeps freed memory
/// for a while, multiplies what a program needs and lets it lock none of it. The tests have none.
#ifdef TRIBUS_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace tribus::test
