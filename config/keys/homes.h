#pragma once

#include <string>
#include <string_view>

namespace tribus {

/// The first table in which a key with exactly that name may stand, for messages: `[output.NAME]`,
/// `[input.NAME] with protocol "x"`. Empty if there is none. Keys of `protocol` are preferred to
/// those of others, and keys of `side` ("input" or "output") to those of the other side. Both may
/// be empty.
std::string home_of_key(std::string_view name, std::string_view side, std::string_view protocol);

}  // namespace tribus
