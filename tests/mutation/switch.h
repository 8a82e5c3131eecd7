#pragma once

/// Included before every source that has made mutations (make.py): which of them is switched on.
namespace tribus_mutation {

/// The number in TRIBUS_MUTATION; 0 is none.
extern int chosen;
/// A byte for each mutation, shared with all processes of a test; null unless somebody asks.
extern unsigned char* reached;

inline bool mutated(int number) {
    if (__builtin_expect(reached != nullptr, 0)) {
        reached[number] = 1;
    }
    return __builtin_expect(chosen == number, 0);
}

/// For a function that the compiler may call: there, nothing is mutated.
constexpr bool mutated_at_run_time(int number) {
    return !__builtin_is_constant_evaluated() && mutated(number);
}

}  // namespace tribus_mutation
