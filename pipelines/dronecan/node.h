#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "pipelines/dronecan/allocation.h"
#include "pipelines/dronecan/node_settings.h"
#include "transports/codecs/dronecan/node_identity.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_node.h"
#include "transports/codecs/dronecan/types_param.h"

namespace tribus::dronecan {

enum class NodeStage : std::uint8_t {
    allocating,  ///< waits for an id
    online,
    conflict,  ///< another node has the same id: this one is silent
};

/// Events of one node since start. Only ever incremented.
struct NodeCounts {
    std::uint64_t sent = 0;      ///< transfers of the node itself
    std::uint64_t received = 0;  ///< transfers that it took
    std::uint64_t errors = 0;    ///< transfers that were damaged, or of which frames were missing
    std::uint64_t requests = 0;  ///< that it answered
    std::uint64_t dropped = 0;   ///< transfers that the bus did not take in time
    std::uint64_t conflicts = 0;
};

/// What is known of a node, for those who tell people.
struct NodeReport {
    NodeStage stage = NodeStage::online;
    NodeId id = kNobody;
    NodeCounts counts;
    bool restart_wanted = false;
};

/// What a node says of the appliance behind it.
enum class NodeHealth : std::uint8_t { ok, warning, error, critical };

/// A written parameter: the period of an output.
struct PeriodWish {
    std::size_t output = 0;
    Duration period{};
};

/// One node on one interface: says that it is there, answers those who ask, gets an id where it has
/// none, and keeps quiet where another node has the same (docs/protocols/can.md, "DroneCAN:
/// nodes"). Makes no system call and no allocation after construction. Thread-bound.
///
/// The transfers that it wants to send wait for the bus one behind the other, each for a second
/// at most, when whoever asked has given up.
class Node {
  public:
    /// How long another node with the same id must be silent before this one speaks again.
    static constexpr Duration kConflictSilence = std::chrono::seconds(5);

    explicit Node(NodeSettings settings);

    void start(Instant now);
    /// Goes on as `before`, a node of the same interface, id and name, which is left without use.
    /// A parameter that was written keeps its value where the configuration still says the same.
    void continue_from(Node& before);
    /// A frame of somebody else on its interface.
    void receive(const CanFrame& frame, Instant at);
    /// Does what is due; returns when to call next at the latest.
    Instant poll(Instant now, NodeHealth health);

    /// Frames of one transfer to be written now; empty if there is none.
    std::span<const CanFrame> speech(Instant now) const;
    void written();
    /// The bus still has the transfer before: it stays the next one.
    void busy(Instant now);
    void dropped();
    /// Says that it goes.
    void end(Instant now);

    /// Whose name others may send in. Lives as long as the node.
    const NodeIdentity& identity() const { return identity_; }
    /// The ids that it must hear. Constant.
    std::span<const CanIdMatch> wanted() const { return wanted_; }
    NodeReport report() const;
    /// A parameter that was written since the last call.
    std::optional<PeriodWish> take_wish();
    /// What the interface counts, for those who ask for it.
    void tell_bus(std::uint64_t sent, std::uint64_t received, std::uint64_t errors);

  private:
    struct Waiting {
        std::array<CanFrame, kMostSnapshotFrames> frames{};
        std::size_t count = 0;
        Instant since{};
    };

    void watch_for_conflict(const TransferHead& head, Instant at);
    void count_errors(const TransferReceiver::Taken& taken);
    void serve(const ReceivedTransfer& request);
    void serve_node_info(const ReceivedTransfer& request);
    void serve_parameter(const ReceivedTransfer& request);
    void serve_opcode(const ReceivedTransfer& request);
    void serve_restart(const ReceivedTransfer& request);
    void serve_statistics(const ReceivedTransfer& request);
    template <class Message>
    void respond(const ReceivedTransfer& request, const Message& message);
    template <class Message>
    void queue(const TransferHead& head, const Message& message, bool fd, Instant now);
    std::optional<std::size_t> parameter_for(const ParamGetSet::Request& request) const;
    void write_parameter(Parameter& parameter, const ParamValue& value);
    NodeStatus status(Instant now) const;
    void say_status(Instant now);
    void say_allocation(Instant now);
    void drop_old(Instant now);
    void pop();

    /// Requests of several nodes in one turn; more ask again.
    static constexpr std::size_t kMostWaiting = 8;

    NodeSettings settings_;
    NodeIdentity identity_;
    NodeStage stage_ = NodeStage::online;
    AllocationClient allocation_;
    TransferReceiver receiver_;
    std::vector<CanIdMatch> wanted_;
    std::vector<Waiting> waiting_;
    std::size_t first_waiting_ = 0;
    std::size_t waiting_count_ = 0;
    Instant retry_at_{};
    Instant started_{};
    Instant next_status_ = kNever;
    Instant conflict_seen_{};
    std::uint8_t status_transfer_id_ = 0;
    std::uint8_t allocation_transfer_id_ = 0;
    NodeHealth health_ = NodeHealth::ok;
    bool ending_ = false;
    bool restart_wanted_ = false;
    std::optional<PeriodWish> wish_;
    CanIfaceStats bus_{};
    NodeCounts counts_;
};

}  // namespace tribus::dronecan
