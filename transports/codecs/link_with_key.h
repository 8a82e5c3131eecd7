#pragma once

#include <optional>
#include <string>

#include "core/secret_key.h"

namespace tribus {

/// A link whose messages are proved by a key.
struct LinkWithKey {
    std::string name;
    SecretKey secret{};
    /// Input only: another one that counts too.
    std::optional<SecretKey> old_secret{};
    /// The receivers do not answer: the file that keeps the numbers of this end.
    std::optional<std::string> epoch{};
};

}  // namespace tribus
