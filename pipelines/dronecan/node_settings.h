#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_node.h"

namespace tribus::dronecan {

/// A number of this program that others may read, and write where that is allowed.
struct Parameter {
    std::string name;
    std::int64_t value = 0;
    std::int64_t at_start = 0;
    std::int64_t least = 0;
    std::int64_t most = 0;
    /// Of the output whose period it is, in microseconds; absent: it cannot be written.
    std::optional<std::size_t> output{};
};

/// Its answer is a transfer that one lane can take.
inline constexpr std::size_t kLongestNodeName = 50;

struct NodeSettings {
    /// Its own; with `dynamic` the one that it would like to have, kNobody: any.
    NodeId id = kNobody;
    /// Asks an allocator for an id.
    bool dynamic = false;
    /// Not all zero, and no other node's.
    UniqueId unique_id{};
    std::string name{};
    std::uint8_t version_major = 0;
    std::uint8_t version_minor = 0;
    bool may_restart = false;
    bool may_write = false;  ///< parameters
    std::vector<Parameter> parameters{};
    /// Seed of the random delays by which nodes keep out of each other's way.
    std::uint64_t seed = 1;
};

}  // namespace tribus::dronecan
