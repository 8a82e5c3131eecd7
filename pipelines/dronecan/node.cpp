#include "pipelines/dronecan/node.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "transports/codecs/dronecan/payload.h"

namespace tribus::dronecan {
namespace {

using namespace std::chrono_literals;

constexpr Duration kStatusPeriod = 1s;
/// After this time requesters have given up (docs/protocols/can.md, "DroneCAN: nodes").
constexpr Duration kMostWait = 1s;
/// Pause, a few frames long, before a transfer that the bus did not take is tried again.
constexpr Duration kBusyRetry = 2ms;
constexpr std::uint8_t kStatusPriority = 24;
constexpr std::uint8_t kAllocationPriority = 24;
/// Nodes whose requests are received at the same time. Further ones ask again.
constexpr std::size_t kMostAskers = 8;

std::vector<WantedTransfer> wanted_transfers() {
    return {wanted_transfer<GetNodeInfo::Request>(),        wanted_transfer<ParamGetSet::Request>(),
            wanted_transfer<ParamExecuteOpcode::Request>(), wanted_transfer<RestartNode::Request>(),
            wanted_transfer<GetTransportStats::Request>(),  wanted_transfer<Allocation>()};
}

/// Node with a known id: what is addressed to it, and what was sent under its id. Otherwise all
/// services, allocation messages and the status of other nodes.
std::vector<CanIdMatch> wanted_ids(const NodeSettings& settings) {
    constexpr std::uint32_t kServiceBit = 0x80;
    constexpr std::uint32_t kSourceMask = 0x7F;
    constexpr std::uint32_t kDestinationMask = 0x7F00;
    if (settings.dynamic) {
        return {ids_of(TransferKind::message, Allocation::kId),
                anonymous_ids_of(Allocation::kId),
                ids_of(TransferKind::message, NodeStatus::kId),
                {.id = kServiceBit, .mask = kServiceBit, .extended = true}};
    }
    return {{.id = settings.id, .mask = kSourceMask, .extended = true},
            {.id = static_cast<std::uint32_t>(settings.id) << 8U | kServiceBit,
             .mask = kDestinationMask | kServiceBit,
             .extended = true}};
}

}  // namespace

Node::Node(NodeSettings settings)
    : settings_(std::move(settings)),
      allocation_(settings_.unique_id, settings_.id, settings_.seed),
      receiver_(wanted_transfers(), kMostAskers),
      wanted_(wanted_ids(settings_)),
      waiting_(kMostWaiting) {
    // Transfers that were received before the start must not be answered without an id.
    stage_ = settings_.dynamic ? NodeStage::allocating : NodeStage::online;
}

void Node::start(Instant now) {
    started_ = now;
    if (settings_.dynamic) {
        allocation_.start(now);
        return;
    }
    identity_.id = settings_.id;
    receiver_.set_own(identity_.id);
    next_status_ = now;
}

void Node::continue_from(Node& before) {
    std::swap(*this, before);
    std::swap(settings_, before.settings_);
    for (Parameter& parameter : settings_.parameters) {
        const auto known =
            std::ranges::find(before.settings_.parameters, parameter.name, &Parameter::name);
        if (known != before.settings_.parameters.end() && known->at_start == parameter.at_start) {
            parameter.value = known->value;
        }
    }
    // It holds the index of an output before the reload.
    period_request_.reset();
}

void Node::receive(const CanFrame& frame, Instant at) {
    const auto head = head_of(frame);
    if (!head) {
        return;
    }
    watch_for_conflict(*head, at);
    const auto taken = receiver_.take(frame, at);
    count_errors(taken);
    if (!taken.transfer) {
        return;
    }
    ++counts_.received;
    const ReceivedTransfer& transfer = *taken.transfer;
    if (transfer.head.kind == TransferKind::request) {
        if (identity_.id != kNobody && transfer.head.destination == identity_.id) {
            serve(transfer);
        }
    } else if (stage_ == NodeStage::allocating) {
        if (const auto message = read<Allocation>(transfer.payload, transfer.fd)) {
            allocation_.take(*message, transfer.head.source, at);
        }
    }
}

void Node::watch_for_conflict(const TransferHead& head, Instant at) {
    const NodeId mine = stage_ == NodeStage::conflict ? settings_.id : identity_.id;
    if (mine == kNobody || head.source != mine) {
        return;
    }
    conflict_seen_ = at;
    if (stage_ == NodeStage::conflict) {
        return;
    }
    ++counts_.conflicts;
    waiting_count_ = 0;
    identity_.id = kNobody;
    next_status_ = kNever;
    if (settings_.dynamic) {
        stage_ = NodeStage::allocating;
        receiver_.set_own(kNobody);
        allocation_.start(at);
    } else {
        stage_ = NodeStage::conflict;
    }
}

void Node::count_errors(const TransferReceiver::Taken& taken) {
    const bool error = taken.result == FrameResult::out_of_turn ||
                       taken.result == FrameResult::bad_crc ||
                       taken.result == FrameResult::too_long || taken.broke_off;
    counts_.errors += error ? 1U : 0U;
}

Instant Node::poll(Instant now, NodeHealth health) {
    health_ = health;
    drop_old(now);
    if (stage_ == NodeStage::conflict && now - conflict_seen_ >= kConflictSilence) {
        stage_ = NodeStage::online;
        identity_.id = settings_.id;
        next_status_ = now;
    }
    if (stage_ == NodeStage::allocating) {
        if (const auto id = allocation_.id()) {
            stage_ = NodeStage::online;
            identity_.id = *id;
            receiver_.set_own(*id);
            next_status_ = now;
        } else if (now >= allocation_.due()) {
            queue_allocation(now);
        }
    }
    if (now >= next_status_ && !ending_) {
        queue_status(now);
        next_status_ += kStatusPeriod * ((now - next_status_) / kStatusPeriod + 1);
    }
    Instant next = stage_ == NodeStage::allocating ? allocation_.due() : next_status_;
    if (stage_ == NodeStage::conflict) {
        next = conflict_seen_ + kConflictSilence;
    }
    return waiting_count_ > 0 ? std::min(next, std::max(retry_at_, now)) : next;
}

std::span<const CanFrame> Node::frames_to_send(Instant now) const {
    if (waiting_count_ == 0 || now < retry_at_) {
        return {};
    }
    const Waiting& waiting = waiting_[first_waiting_];
    return {waiting.frames.data(), waiting.count};
}

void Node::written() {
    ++counts_.sent;
    pop();
}

void Node::busy(Instant now) {
    retry_at_ = now + kBusyRetry;
}

void Node::dropped() {
    ++counts_.dropped;
    pop();
}

void Node::end(Instant now) {
    ending_ = true;
    if (identity_.id != kNobody) {
        queue_status(now);
    }
    next_status_ = kNever;
}

NodeReport Node::report() const {
    return {.state = state(), .counts = counts_, .restart_wanted = restart_wanted_};
}

std::optional<PeriodRequest> Node::take_period_request() {
    return std::exchange(period_request_, std::nullopt);
}

void Node::set_bus_counters(std::uint64_t sent, std::uint64_t received, std::uint64_t errors) {
    bus_ = {.frames_tx = sent, .frames_rx = received, .errors = errors};
}

void Node::serve(const ReceivedTransfer& request) {
    switch (request.head.data_type_id) {
        case GetNodeInfo::kId:
            serve_node_info(request);
            break;
        case ParamGetSet::kId:
            serve_parameter(request);
            break;
        case ParamExecuteOpcode::kId:
            serve_opcode(request);
            break;
        case RestartNode::kId:
            serve_restart(request);
            break;
        case GetTransportStats::kId:
            serve_statistics(request);
            break;
        default:
            break;
    }
}

void Node::serve_node_info(const ReceivedTransfer& request) {
    GetNodeInfo::Response response;
    response.status = status(request.first_at);
    response.software_version.major = settings_.version_major;
    response.software_version.minor = settings_.version_minor;
    response.hardware_version.unique_id = settings_.unique_id;
    response.name = BoundedText<80>(settings_.name);
    respond(request, response);
}

void Node::serve_parameter(const ReceivedTransfer& transfer) {
    const auto request = read<ParamGetSet::Request>(transfer.payload, transfer.fd);
    if (!request) {
        return;
    }
    ParamGetSet::Response response;
    if (const auto index = parameter_for(*request)) {
        Parameter& parameter = settings_.parameters[*index];
        write_parameter(parameter, request->value);
        response.value.held = parameter.value;
        response.default_value.held = parameter.at_start;
        response.max_value.held = parameter.most;
        response.min_value.held = parameter.least;
        response.name = BoundedText<92>(parameter.name);
    }
    respond(transfer, response);
}

std::optional<std::size_t> Node::parameter_for(const ParamGetSet::Request& request) const {
    const auto& parameters = settings_.parameters;
    const auto found =
        request.name.empty()
            ? parameters.begin() + std::min<std::ptrdiff_t>(request.index, std::ssize(parameters))
            : std::ranges::find(parameters, request.name.view(), &Parameter::name);
    return found == parameters.end()
               ? std::nullopt
               : std::optional(static_cast<std::size_t>(found - parameters.begin()));
}

/// A value that is not allowed changes nothing. The response then has the present value.
void Node::write_parameter(Parameter& parameter, const ParamValue& value) {
    const auto* number = std::get_if<std::int64_t>(&value.held);
    if (number == nullptr || !settings_.may_write || !parameter.output ||
        *number < parameter.least || *number > parameter.most) {
        return;
    }
    parameter.value = *number;
    period_request_ = PeriodRequest{*parameter.output, std::chrono::microseconds(*number)};
}

/// Save and erase do nothing: no parameter outlives the program.
void Node::serve_opcode(const ReceivedTransfer& transfer) {
    if (read<ParamExecuteOpcode::Request>(transfer.payload, transfer.fd)) {
        respond(transfer, ParamExecuteOpcode::Response{});
    }
}

void Node::serve_restart(const ReceivedTransfer& transfer) {
    const auto request = read<RestartNode::Request>(transfer.payload, transfer.fd);
    if (!request) {
        return;
    }
    const bool granted =
        settings_.may_restart && request->magic_number == RestartNode::kMagicNumber;
    restart_wanted_ = restart_wanted_ || granted;
    respond(transfer, RestartNode::Response{.ok = granted});
}

void Node::serve_statistics(const ReceivedTransfer& request) {
    GetTransportStats::Response response;
    response.transfers_tx = counts_.sent;
    response.transfers_rx = counts_.received;
    response.transfer_errors = counts_.errors;
    response.can_iface_stats.push_back(bus_);
    respond(request, response);
}

template <class Message>
void Node::respond(const ReceivedTransfer& request, const Message& message) {
    ++counts_.requests;
    queue({.kind = TransferKind::response,
           .data_type_id = request.head.data_type_id,
           .source = identity_.id,
           .destination = request.head.source,
           .priority = request.head.priority,
           .transfer_id = request.head.transfer_id},
          message, request.fd, request.first_at);
}

template <class Message>
void Node::queue(const TransferHead& head, const Message& message, bool fd, Instant now) {
    if (waiting_count_ == waiting_.size()) {
        ++counts_.dropped;
        return;
    }
    Waiting& waiting = waiting_[(first_waiting_ + waiting_count_) % waiting_.size()];
    waiting.since = now;
    waiting.count = encode_transfer(head, data_type_of<Message>().signature, write(message, fd), fd,
                                    waiting.frames);
    waiting_count_ += waiting.count > 0 ? 1U : 0U;
}

NodeStatus Node::status(Instant now) const {
    NodeStatus status;
    status.uptime_sec = static_cast<std::uint32_t>(
        std::chrono::duration_cast<std::chrono::seconds>(now - started_).count());
    status.health = static_cast<std::uint8_t>(health_);
    status.mode = ending_ ? NodeStatus::kModeOffline : NodeStatus::kModeOperational;
    return status;
}

void Node::queue_status(Instant now) {
    queue({.kind = TransferKind::message,
           .data_type_id = NodeStatus::kId,
           .source = identity_.id,
           .priority = kStatusPriority,
           .transfer_id = status_transfer_id_},
          status(now), false, now);
    status_transfer_id_ = (status_transfer_id_ + 1) & kMostTransferId;
}

void Node::queue_allocation(Instant now) {
    queue({.kind = TransferKind::message,
           .data_type_id = Allocation::kId,
           .source = kNobody,
           .priority = kAllocationPriority,
           .transfer_id = allocation_transfer_id_},
          allocation_.run(now), false, now);
    allocation_transfer_id_ = (allocation_transfer_id_ + 1) & kMostTransferId;
}

void Node::drop_old(Instant now) {
    while (waiting_count_ > 0 && now - waiting_[first_waiting_].since > kMostWait) {
        dropped();
    }
}

void Node::pop() {
    first_waiting_ = (first_waiting_ + 1) % waiting_.size();
    --waiting_count_;
}

}  // namespace tribus::dronecan
