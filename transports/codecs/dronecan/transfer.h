#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"

/// DroneCAN's transport (UAVCAN v0): payloads of any length in CAN frames, both directions. Source:
/// docs/protocols/can.md, "DroneCAN: transport".
namespace tribus::dronecan {

/// Node id, 1 to 127. 0 means none: the source of an anonymous message, the destination of a
/// message.
using NodeId = std::uint8_t;
inline constexpr NodeId kNobody = 0;
inline constexpr NodeId kMostNodeId = 127;

inline constexpr std::uint8_t kMostTransferId = 31;
inline constexpr std::uint8_t kLowestPriority = 31;  ///< 0 is the highest

enum class TransferKind : std::uint8_t { message, request, response };

/// Bits of the last byte of every frame. A first frame has toggle 0; with toggle 1 it is a frame of
/// Cyphal.
inline constexpr std::uint8_t kTailStart = 0x80;
inline constexpr std::uint8_t kTailEnd = 0x40;
inline constexpr std::uint8_t kTailToggle = 0x20;
inline constexpr std::uint8_t kTailTransferId = 0x1F;
/// Bytes of the CRC in front of the payload, if a transfer has more than one frame.
inline constexpr std::size_t kCrcBytes = 2;

/// The part of a transfer that the CAN id and the tail byte carry.
struct TransferHead {
    TransferKind kind = TransferKind::message;
    std::uint16_t data_type_id = 0;  ///< 16 bits for messages, 2 for anonymous ones, 8 for services
    NodeId source = kNobody;
    NodeId destination = kNobody;  ///< services only
    std::uint8_t priority = kLowestPriority;
    std::uint8_t transfer_id = 0;

    bool operator==(const TransferHead&) const = default;
};

/// The CAN id of a message or service. The id of an anonymous message has a `discriminator` of 14
/// bits, which must differ between nodes.
std::uint32_t can_id_of(const TransferHead& head, std::uint16_t discriminator = 0);
/// Ids with any priority and source, and for services any destination. Without anonymous messages.
CanIdMatch ids_of(TransferKind kind, std::uint16_t data_type_id);
/// Ids of the anonymous messages of a type, 0 to 3, with any priority and discriminator.
CanIdMatch anonymous_ids_of(std::uint16_t data_type_id);
/// Returns nothing if the frame cannot be one of DroneCAN: 11-bit id, remote, no tail byte, a
/// service from or to node 0, a start with toggle 1, an anonymous message of several frames, or a
/// frame that is neither full nor the last one.
std::optional<TransferHead> head_of(const CanFrame& frame);

/// The CRC of a transfer of several frames: over the signature of its type and the payload, in FD
/// frames including the padding of the last one.
std::uint16_t transfer_crc(std::uint64_t signature, std::span<const std::uint8_t> payload);

/// Number of frames of a payload, classic or FD.
std::size_t frame_count(std::size_t payload_bytes, bool fd);

/// Writes the frames of one transfer in sending order and returns their number; FD frames have bit
/// rate switching. Returns 0 if `frames` has too little room, for an anonymous message of more than
/// one frame or with a type above 3, and for a service from or to node 0. The discriminator of an
/// anonymous message is computed from its payload. Pure and reentrant.
std::size_t encode_transfer(const TransferHead& head, std::uint64_t signature,
                            std::span<const std::uint8_t> payload, bool fd,
                            std::span<CanFrame> frames);

/// A kind of transfer to receive.
struct WantedTransfer {
    TransferKind kind = TransferKind::message;
    std::uint16_t data_type_id = 0;
    std::uint64_t signature = 0;
    /// Longer payloads are refused.
    std::size_t most_bytes = 0;
};

/// A complete transfer. FD payloads may have zeros after their end, since not every length exists
/// in FD, but none is longer than the type's `most_bytes`.
struct ReceivedTransfer {
    TransferHead head;
    bool fd = false;
    /// Arrival of its first frame: no value in it is newer.
    Instant first_at{};
    std::span<const std::uint8_t> payload;  ///< valid until the next frame
};

/// What the receiver did with a frame.
enum class FrameResult : std::uint8_t {
    foreign,      ///< not a frame of DroneCAN
    unwanted,     ///< of another type, or a service to another node
    taken,        ///< part of an unfinished transfer
    complete,     ///< the last one of a transfer
    repeated,     ///< of a finished transfer, or a copy of the frame before
    out_of_turn,  ///< toggle or transfer id do not follow: a frame was lost
    bad_crc,      ///< the last one, but the transfer is damaged, or its type has another signature
                  ///< here
    too_long,     ///< longer than the type can be
    crowded_out,  ///< more senders than there is room for
};
inline constexpr std::size_t kFrameResultCount = 9;

/// Collects transfers by the rules of the specification (docs/protocols/can.md, "DroneCAN:
/// transport"): one transfer at a time for each sender and type; a start of another transfer begins
/// a new one; frames that do not follow are ignored; after 2 s the transfer before is forgotten.
/// Stricter than the specification: a frame without a start never begins a transfer, and one with a
/// start never continues one. Allocates only at construction. Pure. Thread-bound.
class TransferReceiver {
  public:
    /// `most_senders`: limit for each wanted transfer. A further sender replaces one that has begun
    /// no transfer for 2 s. Anonymous senders do not count.
    TransferReceiver(std::vector<WantedTransfer> wanted, std::size_t most_senders);
    TransferReceiver(const TransferReceiver&) = delete;
    TransferReceiver& operator=(const TransferReceiver&) = delete;
    TransferReceiver(TransferReceiver&&) = default;
    TransferReceiver& operator=(TransferReceiver&&) = default;
    ~TransferReceiver() = default;

    /// Ignores services to other nodes. With kNobody, the initial value, receives all.
    void set_own(NodeId own) { own_ = own; }

    struct Taken {
        FrameResult result = FrameResult::foreign;
        /// The transfer before, of this sender and type, was never finished.
        bool broke_off = false;
        std::optional<ReceivedTransfer> transfer;
    };
    Taken take(const CanFrame& frame, Instant at);

    /// Number of frames by what was done with them. The counts only ever increase.
    const std::array<std::uint64_t, kFrameResultCount>& counts() const { return counts_; }
    std::uint64_t broken_off() const { return broken_off_; }

  private:
    /// State of one sender's transfers of one type to one destination.
    struct Session {
        bool used = false;
        NodeId source = kNobody;
        NodeId destination = kNobody;
        std::uint8_t transfer_id = 0;  ///< of the expected transfer
        bool collecting = false;       ///< its start was received
        bool too_long = false;
        bool toggle = false;  ///< of the expected frame
        bool fd = false;
        Instant first_at{};  ///< of the latest start
        std::size_t size = 0;
        std::span<std::uint8_t> room;

        bool forgotten(Instant at) const;
        void begin(std::uint8_t id, bool in_fd_frames, Instant at);
        bool ends_in(std::span<const std::uint8_t> bytes) const;
        FrameResult start(const CanFrame& frame, Instant at, bool& broke_off);
        FrameResult follow(const CanFrame& frame, Instant at, bool& broke_off);
        /// `most_bytes`: limit of the payload.
        FrameResult add(const CanFrame& frame, std::size_t most_bytes);
    };

    Taken judge(const CanFrame& frame, Instant at);
    std::size_t wanted_index(const TransferHead& head) const;
    /// The sender's session, or a free one, or null.
    Session* session_for(std::size_t index, const TransferHead& head, Instant at);

    std::vector<WantedTransfer> wanted_;
    std::size_t most_senders_ = 0;
    std::vector<std::uint8_t> room_;
    std::vector<Session> sessions_;  ///< those of the first wanted transfer, of the second, ...
    Session anonymous_;
    NodeId own_ = kNobody;
    std::array<std::uint64_t, kFrameResultCount> counts_{};
    std::uint64_t broken_off_ = 0;
};

}  // namespace tribus::dronecan
