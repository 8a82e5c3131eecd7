#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_node.h"

namespace tribus::dronecan {

/// A number of this program that other nodes may read and, if permitted, write.
struct Parameter {
    std::string name;
    std::int64_t value = 0;
    std::int64_t at_start = 0;
    std::int64_t least = 0;
    std::int64_t most = 0;
    /// Index of the output whose period in microseconds it is. Absent: read-only.
    std::optional<std::size_t> output{};
};

/// With this length the response to GetNodeInfo still fits into one lane of a CAN link.
inline constexpr std::size_t kLongestNodeName = 50;

struct NodeSettings {
    /// Own id. With `dynamic`: the preferred id, kNobody for any.
    NodeId id = kNobody;
    /// Gets an id from an allocator.
    bool dynamic = false;
    /// Not all zero, and different from that of every other node.
    UniqueId unique_id{};
    std::string name{};
    std::uint8_t version_major = 0;
    std::uint8_t version_minor = 0;
    bool may_restart = false;
    bool may_write = false;  ///< permits others to write parameters
    std::vector<Parameter> parameters{};
    /// Seed of the random pauses that keep allocation requests of several nodes apart.
    std::uint64_t seed = 1;
};

}  // namespace tribus::dronecan
