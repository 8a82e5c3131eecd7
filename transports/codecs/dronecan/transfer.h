#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"

/// DroneCAN's transport (UAVCAN v0): payloads of any length in CAN frames, and back. Facts:
/// docs/protocols/can.md, "DroneCAN: transport", from the specification's chapter 4.
namespace tribus::dronecan {

/// 1 to 127. 0 stands for nobody: the source of an anonymous message, the destination of a message.
using NodeId = std::uint8_t;
inline constexpr NodeId kNobody = 0;
inline constexpr NodeId kMostNodeId = 127;

inline constexpr std::uint8_t kMostTransferId = 31;
inline constexpr std::uint8_t kLowestPriority = 31;  ///< 0 is the highest

enum class TransferKind : std::uint8_t { message, request, response };

/// The last byte of every frame. The first frame's toggle is 0; where it is 1, the frame is one of
/// Cyphal.
inline constexpr std::uint8_t kTailStart = 0x80;
inline constexpr std::uint8_t kTailEnd = 0x40;
inline constexpr std::uint8_t kTailToggle = 0x20;
inline constexpr std::uint8_t kTailTransferId = 0x1F;
/// In front of the payload, where that takes more than one frame.
inline constexpr std::size_t kCrcBytes = 2;

/// What the CAN id and the tail byte tell of a transfer.
struct TransferHead {
    TransferKind kind = TransferKind::message;
    std::uint16_t data_type_id = 0;  ///< messages 16 bits, anonymous ones 2, services 8
    NodeId source = kNobody;
    NodeId destination = kNobody;  ///< of services
    std::uint8_t priority = kLowestPriority;
    std::uint8_t transfer_id = 0;

    bool operator==(const TransferHead&) const = default;
};

/// The CAN id of a message or service. Of an anonymous message it carries `discriminator` (14
/// bits), which must differ from node to node.
std::uint32_t can_id_of(const TransferHead& head, std::uint16_t discriminator = 0);
/// Any priority and source, and of services any destination; no anonymous messages.
CanIdMatch ids_of(TransferKind kind, std::uint16_t data_type_id);
/// Any priority and discriminator of the anonymous messages of a type, 0 to 3.
CanIdMatch anonymous_ids_of(std::uint16_t data_type_id);
/// Nothing where the frame cannot be one of DroneCAN: 11-bit id, remote, without a tail byte, a
/// service to or from nobody, a start with a toggle, an anonymous message of several frames, a
/// frame that is neither the last one nor full.
std::optional<TransferHead> head_of(const CanFrame& frame);

/// Of a transfer of several frames, over the signature of its type and what it carries: in FD
/// frames the padding of the last one too.
std::uint16_t transfer_crc(std::uint64_t signature, std::span<const std::uint8_t> payload);

/// Of a payload in classic frames, or in FD frames with bit rate switching.
std::size_t frame_count(std::size_t payload_bytes, bool fd);

/// Writes the frames of one transfer in the order in which they go out and returns how many; 0
/// where they are more than there is room for, where an anonymous message would be more than one
/// or its type is above 3, and of a service to or from nobody. The discriminator of an anonymous
/// message comes from what it carries. Pure.
std::size_t encode_transfer(const TransferHead& head, std::uint64_t signature,
                            std::span<const std::uint8_t> payload, bool fd,
                            std::span<CanFrame> frames);

/// A transfer that a receiver listens to.
struct WantedTransfer {
    TransferKind kind = TransferKind::message;
    std::uint16_t data_type_id = 0;
    std::uint64_t signature = 0;
    /// Longer ones are refused.
    std::size_t most_bytes = 0;
};

/// One whole transfer, as its type describes it. FD payloads may have zeros behind their end, as an
/// FD frame does not have every length; none is longer than the type's `most_bytes`.
struct ReceivedTransfer {
    TransferHead head;
    bool fd = false;
    /// When its first frame came: no value in it is younger.
    Instant first_at{};
    std::span<const std::uint8_t> payload;  ///< valid until the next frame
};

/// What became of a frame.
enum class FrameFate : std::uint8_t {
    foreign,      ///< nothing of DroneCAN
    unwanted,     ///< of another type, or a service to another node
    taken,        ///< of a transfer that goes on
    complete,     ///< the last one of a transfer
    repeated,     ///< of a transfer that is through, or a copy of the frame before
    out_of_turn,  ///< toggle or transfer id of no frame that can follow: one got lost
    bad_crc,      ///< the last one, but the transfer is damaged, or its type is another one here
    too_long,     ///< more than the type can have
    crowded_out,  ///< more senders than there is room for
};
inline constexpr std::size_t kFrameFateCount = 9;

/// Puts transfers together by the rules of the specification: of each sender and type one transfer
/// at a time; a start that is not of the transfer before begins anew; whatever does not follow is
/// passed over; after 2 s the transfer before is forgotten. What is stricter here: a frame without
/// a start never begins a transfer, and one with a start never continues one. Bounded memory, all
/// of it taken at construction. Pure. Thread-bound: one thread at a time.
class TransferReceiver {
  public:
    /// `most_senders`: of each wanted transfer at one time; a further one takes the place of one
    /// that has begun no transfer for 2 s. Anonymous senders need no place.
    TransferReceiver(std::vector<WantedTransfer> wanted, std::size_t most_senders);
    TransferReceiver(const TransferReceiver&) = delete;
    TransferReceiver& operator=(const TransferReceiver&) = delete;
    TransferReceiver(TransferReceiver&&) = default;
    TransferReceiver& operator=(TransferReceiver&&) = default;
    ~TransferReceiver() = default;

    /// Services that are for another node are passed over. kNobody, as at first: all are taken.
    void set_own(NodeId own) { own_ = own; }

    struct Taken {
        FrameFate fate = FrameFate::foreign;
        /// The transfer before it of this sender and type was never finished.
        bool broke_off = false;
        std::optional<ReceivedTransfer> transfer;
    };
    Taken take(const CanFrame& frame, Instant at);

    /// Of each fate. Only ever incremented.
    const std::array<std::uint64_t, kFrameFateCount>& fates() const { return fates_; }
    std::uint64_t broken_off() const { return broken_off_; }

  private:
    /// What is known of one sender's transfers of one type to one destination.
    struct Session {
        bool used = false;
        NodeId source = kNobody;
        NodeId destination = kNobody;
        std::uint8_t transfer_id = 0;  ///< of the transfer that is due
        bool collecting = false;       ///< its start was there
        bool too_long = false;
        bool toggle = false;  ///< of the frame that is due
        bool fd = false;
        Instant first_at{};  ///< of the last start
        std::size_t size = 0;
        std::span<std::uint8_t> room;

        bool forgotten(Instant at) const;
        void begin(std::uint8_t id, bool in_fd_frames, Instant at);
        bool ends_in(std::span<const std::uint8_t> bytes) const;
        FrameFate start(const CanFrame& frame, Instant at, bool& broke_off);
        FrameFate follow(const CanFrame& frame, Instant at, bool& broke_off);
        /// `most_bytes` of the payload.
        FrameFate add(const CanFrame& frame, std::size_t most_bytes);
    };

    Taken judge(const CanFrame& frame, Instant at);
    std::size_t wanted_index(const TransferHead& head) const;
    /// The sender's own, or one that it can have, or nothing.
    Session* session_for(std::size_t index, const TransferHead& head, Instant at);

    std::vector<WantedTransfer> wanted_;
    std::size_t most_senders_ = 0;
    std::vector<std::uint8_t> room_;
    std::vector<Session> sessions_;  ///< of the first wanted one, of the second, ...
    Session anonymous_;
    NodeId own_ = kNobody;
    std::array<std::uint64_t, kFrameFateCount> fates_{};
    std::uint64_t broken_off_ = 0;
};

}  // namespace tribus::dronecan
