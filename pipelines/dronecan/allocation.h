#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/time.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_node.h"

namespace tribus::dronecan {

/// Gets an id from an allocator on the bus, three parts of the unique id one after the other, with
/// random pauses (docs/protocols/can.md, "DroneCAN: nodes"). Pure; thread-bound.
class AllocationClient {
  public:
    AllocationClient(UniqueId unique_id, NodeId preferred, std::uint64_t seed);

    void start(Instant now);
    /// Somebody's allocation message: another candidate's, or an answer.
    void take(const Allocation& message, NodeId source, Instant at);
    Instant due() const { return next_; }
    /// What to say now, from nobody; call when due.
    Allocation run(Instant now);
    /// Once there is one.
    std::optional<NodeId> id() const { return id_; }

  private:
    Duration random_pause(Duration least, Duration most);

    UniqueId unique_id_;
    NodeId preferred_;
    std::uint64_t random_;
    std::size_t confirmed_ = 0;  ///< bytes of the unique id that the allocator has
    Instant next_ = kNever;
    std::optional<NodeId> id_;
};

}  // namespace tribus::dronecan
