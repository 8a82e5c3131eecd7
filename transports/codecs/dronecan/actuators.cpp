#include "transports/codecs/dronecan/actuators.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "core/rounding.h"
#include "transports/codecs/dronecan/payload.h"

namespace tribus::dronecan {
namespace {

constexpr double kNeutral = 1500;
constexpr double kHalfTravel = 500;
constexpr double kLowest = 1000;
constexpr double kTravel = 1000;
constexpr double kMostThrottle = 8191;
constexpr double kLeastThrottle = -8192;
/// Permissions come once or twice a second. After this time one no longer counts: the whole node is
/// then gone (docs/protocols/can.md, "DroneCAN: nodes").
constexpr Duration kPermissionLasts = std::chrono::seconds(3);
/// After such a silence a vehicle starts anew, perhaps with fewer actuators.
constexpr Duration kNewBeginning = std::chrono::seconds(1);
/// Period of the permissions that are sent. Short, because nodes wait for the first one.
constexpr Duration kPermissionPeriod = std::chrono::milliseconds(200);
constexpr std::uint8_t kPermissionPriority = 16;

std::uint16_t command_id(CommandKind kind) {
    return kind == CommandKind::servos ? ArrayCommand::kId : EscRawCommand::kId;
}

WantedTransfer wanted_command(CommandKind kind) {
    return kind == CommandKind::servos ? wanted_transfer<ArrayCommand>()
                                       : wanted_transfer<EscRawCommand>();
}

/// Nothing for positions, forces and speeds, which are no pulses.
std::optional<Pulse> pulse_of(const ActuatorCommand& command) {
    const double value = command.command_value;
    if (!std::isfinite(value)) {
        return std::nullopt;
    }
    switch (command.command_type) {
        case ActuatorCommand::kUnitless:
            return Pulse::from_fractional_microseconds(kNeutral +
                                                       kHalfTravel * std::clamp(value, -1.0, 1.0));
        case ActuatorCommand::kPwm:
            return Pulse::from_fractional_microseconds(value);
        default:
            return std::nullopt;
    }
}

Pulse pulse_of_throttle(std::int16_t throttle, bool reversible) {
    const double share = throttle / kMostThrottle;
    return Pulse::from_fractional_microseconds(reversible
                                                   ? kNeutral + kHalfTravel * std::max(share, -1.0)
                                                   : kLowest + kTravel * std::max(share, 0.0));
}

std::int16_t throttle_of(Pulse pulse, bool reversible) {
    const double share = reversible ? (pulse.microseconds() - kNeutral) / kHalfTravel
                                    : std::max((pulse.microseconds() - kLowest) / kTravel, 0.0);
    return static_cast<std::int16_t>(
        nearest_whole(std::clamp(share * kMostThrottle, kLeastThrottle, kMostThrottle)));
}

}  // namespace

CommandDecoder::CommandDecoder(CommandInputFormat format)
    : format_(format),
      wanted_{ids_of(TransferKind::message, command_id(format.kind)),
              ids_of(TransferKind::message, SafetyState::kId),
              ids_of(TransferKind::message, ArmingStatus::kId)},
      source_(format.source),
      receiver_({wanted_command(format.kind), wanted_transfer<SafetyState>(),
                 wanted_transfer<ArmingStatus>()},
                format.source.node ? 1 : kMostCandidates),
      details_{{{"source_node", {&detail_values_[0], 1}}}} {
    commanded_.fill(Instant::min());
}

std::optional<ChannelFrame> CommandDecoder::next(const CanFrame& frame, Instant received) {
    const bool wants =
        std::ranges::any_of(wanted_, [&](const CanIdMatch& id) { return id.matches(frame); });
    const auto head = wants ? head_of(frame) : std::nullopt;
    if (!head) {
        return std::nullopt;
    }
    const bool command = head->data_type_id == command_id(format_.kind);
    // Only permissions of the node that commands count.
    const bool accepted =
        command ? source_.would_accept(head->source, received) : head->source == source_.current();
    if (!accepted) {
        rejected_.count_other_source();
        return std::nullopt;
    }
    const auto taken = receiver_.take(frame, received);
    rejected_.count(taken);
    if (!taken.transfer) {
        return std::nullopt;
    }
    if (!command) {
        take_permission(*taken.transfer);
        return std::nullopt;
    }
    if (!take_command(*taken.transfer)) {
        return std::nullopt;
    }
    detail_values_ = {head->source};
    return snapshot(taken.transfer->first_at);
}

bool CommandDecoder::take_command(const ReceivedTransfer& transfer) {
    return format_.kind == CommandKind::servos ? take_servos(transfer) : take_motors(transfer);
}

bool CommandDecoder::refuse_layout() {
    rejected_.count_layout();
    return false;
}

bool CommandDecoder::accepts(const ReceivedTransfer& transfer) {
    if (!source_.accepts(transfer.head.source, transfer.first_at)) {
        rejected_.count_other_source();
        return false;
    }
    if (order_.take(transfer.head.transfer_id, true, transfer.first_at) !=
        CounterWatch::Verdict::good) {
        rejected_.count_counter_jump();
        return false;
    }
    if (latest_ != Instant::min() && transfer.first_at - latest_ > kNewBeginning) {
        commanded_.fill(Instant::min());
    }
    latest_ = transfer.first_at;
    return true;
}

bool CommandDecoder::take_servos(const ReceivedTransfer& transfer) {
    const auto message = read<ArrayCommand>(transfer.payload, transfer.fd);
    const auto moves = [](const ActuatorCommand& command) { return pulse_of(command).has_value(); };
    if (!message || std::ranges::none_of(message->commands, moves)) {
        return refuse_layout();
    }
    if (!accepts(transfer)) {
        return false;
    }
    for (const ActuatorCommand& command : message->commands) {
        if (const auto pulse = pulse_of(command)) {
            set(command.actuator_id, *pulse, transfer.first_at);
        }
    }
    return true;
}

bool CommandDecoder::take_motors(const ReceivedTransfer& transfer) {
    const auto message = read<EscRawCommand>(transfer.payload, transfer.fd);
    if (!message || message->cmd.empty()) {
        return refuse_layout();
    }
    if (!accepts(transfer)) {
        return false;
    }
    for (std::size_t motor = 0; motor < message->cmd.size(); ++motor) {
        set(motor, pulse_of_throttle(message->cmd[motor], format_.reversible), transfer.first_at);
    }
    return true;
}

void CommandDecoder::take_permission(const ReceivedTransfer& transfer) {
    if (transfer.head.data_type_id == SafetyState::kId) {
        if (const auto message = read<SafetyState>(transfer.payload, transfer.fd)) {
            safety_ = {message->status == SafetyState::kSafetyOff, transfer.first_at};
        }
    } else if (const auto message = read<ArmingStatus>(transfer.payload, transfer.fd)) {
        arming_ = {message->status == ArmingStatus::kFullyArmed, transfer.first_at};
    }
}

void CommandDecoder::set(std::size_t actuator, Pulse pulse, Instant at) {
    if (actuator >= format_.first && actuator - format_.first < format_.channels) {
        pulses_[actuator - format_.first] = pulse;
        commanded_[actuator - format_.first] = at;
    }
}

bool CommandDecoder::may_move(const Permission& permission, Instant now) const {
    const bool known =
        permission.received != Instant::min() && now - permission.received <= kPermissionLasts;
    return known ? permission.granted : format_.safety != SafetyRule::required;
}

ChannelFrame CommandDecoder::snapshot(Instant now) {
    ChannelFrame frame;
    frame.origin = Origin::dronecan;
    frame.frame_lost = false;
    frame.received = now;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (commanded_[channel] != Instant::min()) {
            frame.set(channel, pulses_[channel]);
            frame.received = std::min(frame.received, commanded_[channel]);
        }
    }
    frame.failsafe = format_.safety != SafetyRule::ignored &&
                     (!may_move(safety_, now) ||
                      (format_.kind == CommandKind::motors && !may_move(arming_, now)));
    return frame;
}

void CommandEncoder::continue_from(const Encoder& before) {
    const auto* same = dynamic_cast<const CommandEncoder*>(&before);
    if (same != nullptr) {
        command_transfer_id_ = same->command_transfer_id_;
        safety_transfer_id_ = same->safety_transfer_id_;
        arming_transfer_id_ = same->arming_transfer_id_;
        ever_in_control_ = same->ever_in_control_;
        permitted_ = same->permitted_;
    }
}

std::size_t CommandEncoder::write(const ChannelFrame& snapshot,
                                  std::span<CanFrame, kMostSnapshotFrames> frames, Instant now) {
    if (identity_->id == kNobody) {
        return 0;
    }
    const std::size_t count = format_.kind == CommandKind::servos ? encode_servos(snapshot, frames)
                                                                  : encode_motors(snapshot, frames);
    return count + encode_permissions(snapshot, now, std::span(frames).subspan(count));
}

std::size_t CommandEncoder::encode_servos(const ChannelFrame& snapshot,
                                          std::span<CanFrame> frames) {
    ArrayCommand message;
    for (std::size_t channel = 0; channel < format_.channels; ++channel) {
        if (const auto pulse = snapshot.channel(channel)) {
            const double value =
                format_.pulses
                    ? pulse->microseconds()
                    : std::clamp((pulse->microseconds() - kNeutral) / kHalfTravel, -1.0, 1.0);
            message.commands.push_back(
                {.actuator_id = static_cast<std::uint8_t>(format_.first + channel),
                 .command_type =
                     format_.pulses ? ActuatorCommand::kPwm : ActuatorCommand::kUnitless,
                 .command_value = static_cast<float>(value)});
        }
    }
    return encode_message(message, CommandOutputFormat::kServoPriority, command_transfer_id_,
                          frames);
}

std::size_t CommandEncoder::encode_motors(const ChannelFrame& snapshot,
                                          std::span<CanFrame> frames) {
    EscRawCommand message;
    for (std::size_t before = 0; before < format_.first; ++before) {
        message.cmd.push_back(0);
    }
    for (std::size_t channel = 0; channel < format_.channels; ++channel) {
        const auto pulse = snapshot.channel(channel);
        message.cmd.push_back(pulse ? throttle_of(*pulse, format_.reversible) : std::int16_t{0});
    }
    return encode_message(message, CommandOutputFormat::kMotorPriority, command_transfer_id_,
                          frames);
}

/// Permits nothing before an input had control, and does not arm motors in failsafe.
std::size_t CommandEncoder::encode_permissions(const ChannelFrame& snapshot, Instant now,
                                               std::span<CanFrame> frames) {
    ever_in_control_ = ever_in_control_ || snapshot.good();
    const bool due = permitted_ == Instant::min() || now - permitted_ >= kPermissionPeriod;
    if (!format_.arms || !ever_in_control_ || !due) {
        return 0;
    }
    permitted_ = now;
    SafetyState safety;
    safety.status = SafetyState::kSafetyOff;
    const std::size_t count =
        encode_message(safety, kPermissionPriority, safety_transfer_id_, frames);
    if (format_.kind == CommandKind::servos) {
        return count;
    }
    ArmingStatus arming;
    arming.status = snapshot.failsafe ? ArmingStatus::kDisarmed : ArmingStatus::kFullyArmed;
    return count +
           encode_message(arming, kPermissionPriority, arming_transfer_id_, frames.subspan(count));
}

template <class Message>
std::size_t CommandEncoder::encode_message(const Message& message, std::uint8_t priority,
                                           std::uint8_t& transfer_id,
                                           std::span<CanFrame> frames) const {
    const auto payload = dronecan::write(message, format_.fd);
    const TransferHead head{.kind = TransferKind::message,
                            .data_type_id = Message::kId,
                            .source = identity_->id,
                            .priority = priority,
                            .transfer_id = transfer_id};
    transfer_id = (transfer_id + 1) & kMostTransferId;
    return encode_transfer(head, Message::kSignature, payload, format_.fd, frames);
}

}  // namespace tribus::dronecan
