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

/// Stage of a node.
enum class NodeStage : std::uint8_t {
    allocating,  ///< waits for an id
    online,
    conflict,  ///< another node has the same id: this one is silent
};

/// Counters of one node since the start. They never decrease.
struct NodeCounts {
    std::uint64_t sent = 0;      ///< own transfers
    std::uint64_t received = 0;  ///< transfers addressed to it, and allocation messages
    std::uint64_t errors = 0;    ///< damaged or incomplete transfers
    std::uint64_t requests = 0;  ///< requests that it answered
    std::uint64_t dropped = 0;   ///< transfers that the bus did not take in time
    std::uint64_t conflicts = 0;
};

struct NodeState {
    NodeStage stage = NodeStage::online;
    NodeId id = kNobody;  ///< the id under which it sends

    bool operator==(const NodeState&) const = default;
};

/// State of a node, for status and log.
struct NodeReport {
    NodeState state{};
    NodeCounts counts;
    bool restart_wanted = false;
};

/// Health that the node reports in NodeStatus.
enum class NodeHealth : std::uint8_t { ok, warning, error, critical };

/// A request to change the period of an output, made by writing a parameter.
struct PeriodRequest {
    std::size_t output = 0;
    Duration period{};
};

/// One DroneCAN node on one interface: sends its status, answers requests, gets an id by allocation
/// if it has none, and is silent while another node has the same id (docs/protocols/can.md,
/// "DroneCAN: nodes"). Makes no system call and does not allocate after construction. Thread-bound.
///
/// Transfers wait in a queue until the bus takes them, each for at most one second: after that the
/// requester has given up.
class Node {
  public:
    /// For this time another node with the same id must be silent before this one sends again.
    static constexpr Duration kConflictSilence = std::chrono::seconds(5);

    explicit Node(NodeSettings settings);

    void start(Instant now);
    /// Takes over the state of `before`, a node with the same interface, id and name, which is
    /// unusable afterwards. A parameter keeps the value that was written if its configured value is
    /// unchanged.
    void continue_from(Node& before);
    /// Takes a CAN frame of another node on its interface.
    void receive(const CanFrame& frame, Instant at);
    /// Does what is due. Returns the time of the next call at the latest.
    Instant poll(Instant now, NodeHealth health);

    /// Frames of one transfer to write now. Empty if there is none.
    std::span<const CanFrame> frames_to_send(Instant now) const;
    /// The frames of `frames_to_send` were handed over.
    void written();
    /// The bus still has the transfer before. The present one stays the next.
    void busy(Instant now);
    /// The frames of `frames_to_send` cannot be sent and are discarded.
    void dropped();
    /// Sends a last status that says that the node goes offline.
    void end(Instant now);

    /// The id under which outputs send. Valid as long as the node.
    const NodeIdentity& identity() const { return identity_; }
    /// The CAN ids that it receives. Constant.
    std::span<const CanIdMatch> wanted() const { return wanted_; }
    NodeState state() const { return {stage_, identity_.id}; }
    NodeReport report() const;
    /// Takes the latest change of a period that was written. `nullopt` if there is none.
    std::optional<PeriodRequest> take_period_request();
    /// Sets the counters of the interface, for requests of statistics.
    void set_bus_counters(std::uint64_t sent, std::uint64_t received, std::uint64_t errors);

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
    void queue_status(Instant now);
    void queue_allocation(Instant now);
    void drop_old(Instant now);
    void pop();

    /// Several nodes may ask at once. A request that finds the queue full is dropped; the node asks
    /// again.
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
    std::optional<PeriodRequest> period_request_;
    CanIfaceStats bus_{};
    NodeCounts counts_;
};

}  // namespace tribus::dronecan
