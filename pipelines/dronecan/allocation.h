#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/time.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_node.h"

namespace tribus::dronecan {

/// Client of dynamic node id allocation: sends the unique id to an allocator in three parts, with
/// random pauses between them (docs/protocols/can.md, "DroneCAN: nodes"). Pure. Thread-bound.
class AllocationClient {
  public:
    /// `preferred`: requested id, kNobody for any. `seed`: of the random pauses.
    AllocationClient(UniqueId unique_id, NodeId preferred, std::uint64_t seed);

    /// Starts, or starts again, to request an id.
    void start(Instant now);
    /// Takes an allocation message: the request of another client, or an answer.
    void take(const Allocation& message, NodeId source, Instant at);
    /// When to call `run` next.
    Instant due() const { return next_; }
    /// Returns the next request, to be sent by an anonymous node. Call when due.
    Allocation run(Instant now);
    /// The allocated id. `nullopt` before.
    std::optional<NodeId> id() const { return id_; }

  private:
    Duration random_pause(Duration least, Duration most);

    UniqueId unique_id_;
    NodeId preferred_;
    std::uint64_t random_;
    std::size_t confirmed_ = 0;  ///< bytes of the unique id that the allocator has confirmed
    Instant next_ = kNever;
    std::optional<NodeId> id_;
};

}  // namespace tribus::dronecan
