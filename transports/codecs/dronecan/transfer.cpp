#include "transports/codecs/dronecan/transfer.h"

#include <algorithm>

#include "transports/codecs/e2e.h"

namespace tribus::dronecan {
namespace {

constexpr unsigned kPriorityAt = 24;
constexpr unsigned kMessageTypeAt = 8;
constexpr unsigned kServiceTypeAt = 16;
constexpr unsigned kDestinationAt = 8;
constexpr unsigned kDiscriminatorAt = 10;

constexpr std::uint32_t kPriorityMask = 0x1F;
constexpr std::uint32_t kNodeMask = 0x7F;
constexpr std::uint32_t kMessageTypeMask = 0xFFFF;
constexpr std::uint32_t kAnonymousTypeMask = 0x3;
constexpr std::uint32_t kServiceTypeMask = 0xFF;
constexpr std::uint32_t kDiscriminatorMask = 0x3FFF;
constexpr std::uint32_t kServiceBit = 1U << 7;
constexpr std::uint32_t kRequestBit = 1U << 15;

constexpr std::uint16_t kCrcStart = 0xFFFF;
constexpr std::array<std::uint8_t, kMostFdBytes> kPadding{};

/// Bytes of the transfer in a frame, without the tail byte.
constexpr std::size_t room_in_frame(bool fd) {
    return (fd ? kMostFdBytes : kMostClassicBytes) - 1;
}

bool can_be_sent(const TransferHead& head, std::size_t frames) {
    if (head.kind != TransferKind::message) {
        return head.source != kNobody && head.destination != kNobody;
    }
    return head.source != kNobody || (frames == 1 && head.data_type_id <= kAnonymousTypeMask);
}

/// The discriminator as in libcanard. Nodes with equal content choose the same one, which does no
/// harm on the bus.
std::uint16_t discriminator_of(std::span<const std::uint8_t> payload) {
    return (crc16_1021(kCrcStart, payload) >> 1U) & kDiscriminatorMask;
}

/// Moves as many bytes from the front of `rest` as both have.
void move_bytes(std::span<const std::uint8_t>& rest, std::span<std::uint8_t>& room) {
    const std::size_t count = std::min(rest.size(), room.size());
    std::ranges::copy(rest.first(count), room.begin());
    rest = rest.subspan(count);
    room = room.subspan(count);
}

bool fits_its_tail(const CanFrame& frame) {
    const std::uint8_t tail = frame.data[frame.length - 1U];
    if ((tail & kTailStart) != 0 && (tail & kTailToggle) != 0) {
        return false;
    }
    return (tail & kTailEnd) != 0 || frame.length == room_in_frame(frame.fd) + 1;
}

TransferHead message_head(std::uint32_t id) {
    const auto source = static_cast<NodeId>(id & kNodeMask);
    const std::uint32_t types = source == kNobody ? kAnonymousTypeMask : kMessageTypeMask;
    return {.kind = TransferKind::message,
            .data_type_id = static_cast<std::uint16_t>((id >> kMessageTypeAt) & types),
            .source = source};
}

TransferHead service_head(std::uint32_t id) {
    return {.kind = (id & kRequestBit) != 0 ? TransferKind::request : TransferKind::response,
            .data_type_id = static_cast<std::uint16_t>((id >> kServiceTypeAt) & kServiceTypeMask),
            .source = static_cast<NodeId>(id & kNodeMask),
            .destination = static_cast<NodeId>((id >> kDestinationAt) & kNodeMask)};
}

}  // namespace

std::uint32_t can_id_of(const TransferHead& head, std::uint16_t discriminator) {
    const std::uint32_t ends =
        (head.priority & kPriorityMask) << kPriorityAt | (head.source & kNodeMask);
    if (head.kind == TransferKind::message && head.source == kNobody) {
        return ends | (discriminator & kDiscriminatorMask) << kDiscriminatorAt |
               (head.data_type_id & kAnonymousTypeMask) << kMessageTypeAt;
    }
    if (head.kind == TransferKind::message) {
        return ends | std::uint32_t{head.data_type_id} << kMessageTypeAt;
    }
    return ends | (head.data_type_id & kServiceTypeMask) << kServiceTypeAt |
           (head.kind == TransferKind::request ? kRequestBit : 0U) |
           (head.destination & kNodeMask) << kDestinationAt | kServiceBit;
}

CanIdMatch ids_of(TransferKind kind, std::uint16_t data_type_id) {
    if (kind == TransferKind::message) {
        return {.id = std::uint32_t{data_type_id} << kMessageTypeAt,
                .mask = kMessageTypeMask << kMessageTypeAt | kServiceBit,
                .extended = true};
    }
    return {.id = (data_type_id & kServiceTypeMask) << kServiceTypeAt |
                  (kind == TransferKind::request ? kRequestBit : 0U) | kServiceBit,
            .mask = kServiceTypeMask << kServiceTypeAt | kRequestBit | kServiceBit,
            .extended = true};
}

CanIdMatch anonymous_ids_of(std::uint16_t data_type_id) {
    return {.id = (data_type_id & kAnonymousTypeMask) << kMessageTypeAt,
            .mask = kAnonymousTypeMask << kMessageTypeAt | kServiceBit | kNodeMask,
            .extended = true};
}

std::optional<TransferHead> head_of(const CanFrame& frame) {
    if (!frame.extended || frame.remote || frame.length == 0 ||
        !valid_can_length(frame.length, frame.fd) || !fits_its_tail(frame)) {
        return std::nullopt;
    }
    const bool service = (frame.id & kServiceBit) != 0;
    TransferHead head = service ? service_head(frame.id) : message_head(frame.id);
    const std::uint8_t tail = frame.data[frame.length - 1U];
    const bool single = (tail & kTailStart) != 0 && (tail & kTailEnd) != 0;
    if (!can_be_sent(head, single ? 1 : 2)) {
        return std::nullopt;
    }
    head.priority = static_cast<std::uint8_t>((frame.id >> kPriorityAt) & kPriorityMask);
    head.transfer_id = tail & kTailTransferId;
    return head;
}

std::uint16_t transfer_crc(std::uint64_t signature, std::span<const std::uint8_t> payload) {
    std::array<std::uint8_t, sizeof signature> low_first{};
    for (std::size_t byte = 0; byte < low_first.size(); ++byte) {
        low_first[byte] = static_cast<std::uint8_t>(signature >> (8 * byte));
    }
    return crc16_1021(crc16_1021(kCrcStart, low_first), payload);
}

std::size_t frame_count(std::size_t payload_bytes, bool fd) {
    const std::size_t room = room_in_frame(fd);
    return payload_bytes <= room ? 1 : (payload_bytes + kCrcBytes + room - 1) / room;
}

std::size_t encode_transfer(const TransferHead& head, std::uint64_t signature,
                            std::span<const std::uint8_t> payload, bool fd,
                            std::span<CanFrame> frames) {
    const std::size_t count = frame_count(payload.size(), fd);
    if (count > frames.size() || !can_be_sent(head, count)) {
        return 0;
    }
    const std::size_t room = room_in_frame(fd);
    const std::size_t carried = payload.size() + (count > 1 ? kCrcBytes : 0);
    const std::size_t in_last = carried - (count - 1) * room;
    const std::size_t last_length = fd ? can_length_for(in_last + 1) : in_last + 1;
    const std::span padding = std::span(kPadding).first(last_length - 1 - in_last);

    const std::uint16_t crc = crc16_1021(transfer_crc(signature, payload), padding);
    const std::array<std::uint8_t, kCrcBytes> crc_low_first{static_cast<std::uint8_t>(crc),
                                                            static_cast<std::uint8_t>(crc >> 8U)};
    std::span<const std::uint8_t> rest_of_crc =
        std::span(crc_low_first).first(count > 1 ? kCrcBytes : 0);
    const std::uint32_t id = can_id_of(head, discriminator_of(payload));
    for (std::size_t index = 0; index < count; ++index) {
        const bool last = index + 1 == count;
        CanFrame& frame = frames[index];
        frame = {.id = id, .extended = true, .fd = fd, .bit_rate_switch = fd};
        frame.length = static_cast<std::uint8_t>(last ? last_length : room + 1);
        std::span<std::uint8_t> data = frame.bytes().first(frame.length - 1U);
        move_bytes(rest_of_crc, data);
        move_bytes(payload, data);
        frame.data[frame.length - 1U] = static_cast<std::uint8_t>(
            (index == 0 ? kTailStart : 0U) | (last ? kTailEnd : 0U) |
            (index % 2 != 0 ? kTailToggle : 0U) | (head.transfer_id & kTailTransferId));
    }
    return count;
}

}  // namespace tribus::dronecan
