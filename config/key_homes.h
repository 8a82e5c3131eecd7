#pragma once

#include <string>
#include <string_view>

namespace tribus {

/// The first place in the language where a key of exactly that name may stand, for messages:
/// `[output.NAME]`, `[input.NAME] with protocol "x"`; empty if there is none. The keys of
/// `protocol` come before those of others, and those of the same `side`, "input" or "output",
/// before those of the other; both may be empty.
std::string home_of_key(std::string_view name, std::string_view side, std::string_view protocol);

}  // namespace tribus
