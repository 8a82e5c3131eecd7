#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include "core/time.h"
#include "transports/codecs/dronecan/known_payloads.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/recordings/recording.h"

/// Transfers in the frames of a DroneCAN bus, and why some of them are broken.
namespace tribus {

/// What is wrong with a transfer.
enum class TransferFault : std::uint8_t {
    none,
    bad_crc,         ///< damaged, or the sender's type has another signature
    frames_missing,  ///< a frame within it, as the toggle bit shows
    start_missing,   ///< its first frame
    broke_off,       ///< its last frame never came
    cut,             ///< the recording ends before it does
    too_long,        ///< longer than its type allows
    layout,          ///< payload does not fit its type
    repeated,        ///< the transfer before once more; receivers ignore it
    crowded_out,     ///< not decoded: too many senders and types at the same time
};
inline constexpr std::size_t kTransferFaultCount = 10;
/// Names in JSON.
inline constexpr std::array<std::string_view, kTransferFaultCount> kTransferFaultNames{
    "none", "bad_crc",  "frames_missing", "start_missing", "broke_off",
    "cut",  "too_long", "layout",         "repeated",      "crowded_out"};

/// A complete or broken transfer.
struct ExplainedTransfer {
    Duration first_at{};  ///< arrival of its first frame that came,
    Duration last_at{};   ///< and of its last one
    dronecan::TransferHead head;
    bool fd = false;
    std::size_t frames = 0;
    const dronecan::KnownPayload* type = nullptr;  ///< null for unknown types
    TransferFault fault = TransferFault::none;
    /// The transfer has several frames and an unknown type, so its CRC cannot be checked.
    bool crc_unchecked = false;
    std::vector<std::uint8_t>
        payload;  ///< without the CRC; of a broken transfer, the part that came
    /// For a response whose request was seen: time between their last frames.
    std::optional<Duration> answered_after;
};

using TransferCounts = std::array<std::uint64_t, kTransferFaultCount>;

/// The transfers of one type from one node.
struct TransferStream {
    dronecan::NodeId source = dronecan::kNobody;
    dronecan::TransferKind kind = dronecan::TransferKind::message;
    std::uint16_t data_type_id = 0;

    auto operator<=>(const TransferStream&) const = default;
};

/// Counters of a log.
struct TransferTally {
    std::uint64_t bytes = 0;  ///< of data
    std::uint64_t can_frames = 0;
    std::uint64_t other_can_frames = 0;  ///< that cannot be DroneCAN
    std::uint64_t repeated_frames = 0;   ///< copies; not part of any transfer
    TransferCounts counts{};             ///< by fault
    std::uint64_t of_known_type = 0;     ///< complete ones
    std::uint64_t requests = 0;
    std::uint64_t responses = 0;
    std::uint64_t answered = 0;  ///< requests whose response came
    std::map<TransferStream, TransferCounts> streams;
    LogFacts log{};
};

/// Assembles the transfers of all nodes, of known and unknown types, by the rules of
/// dronecan::TransferReceiver. Memory is bounded for any length of a log. Thread-bound.
class DroneCanExplainer {
  public:
    using Handler = std::function<void(const ExplainedTransfer&)>;
    /// `handler` gets each transfer when its last frame has come, and broken ones when the fault is
    /// known.
    explicit DroneCanExplainer(Handler handler) : handler_(std::move(handler)) {}

    /// Feeds a frame, in the order of the log.
    void feed(const RecordedCanFrame& recorded);
    /// Reports the transfers that are still incomplete.
    void finish();
    const TransferTally& tally() const { return tally_; }

  private:
    /// The frames of a transfer so far.
    struct Part {
        bool open = false;
        bool has_start = false;
        bool single = false;     ///< the transfer has only one frame
        bool disturbed = false;  ///< a frame came that could not follow
        dronecan::TransferHead head;
        bool fd = false;
        std::size_t frames = 0;
        Duration first_at{};
        Duration last_at{};
        std::vector<std::uint8_t> bytes;

        void begin(const dronecan::TransferHead& begun, const RecordedCanFrame& recorded);
        void add(const RecordedCanFrame& recorded);
    };
    /// Transfers of one type from one sender to one destination.
    struct Session {
        explicit Session(const dronecan::TransferHead& head);

        const dronecan::KnownPayload* type;
        dronecan::TransferReceiver receiver;
        Part current;
        Part stray;  ///< of frames that the receiver rejected
        TransferFault stray_fault = TransferFault::none;
        Duration last_at{};
    };
    using Key =
        std::tuple<dronecan::TransferKind, std::uint16_t, dronecan::NodeId, dronecan::NodeId>;
    /// Client, server, service and transfer id.
    using Call = std::tuple<dronecan::NodeId, dronecan::NodeId, std::uint16_t, std::uint8_t>;

    Session* session_of(const dronecan::TransferHead& head, Duration now);
    void forget_silent_ones(Duration now);
    void take(Session& session, const dronecan::TransferHead& head,
              const RecordedCanFrame& recorded);
    void collect(Session& session, const dronecan::TransferHead& head,
                 const RecordedCanFrame& recorded, dronecan::FrameResult result);
    void collect_stray(Session& session, const dronecan::TransferHead& head,
                       const RecordedCanFrame& recorded, TransferFault fault);
    void end_current(Session& session, TransferFault fault);
    void end_stray(Session& session);
    void end_unfinished(Session& session, Duration now);
    void report(const Part& part, const dronecan::KnownPayload* type, TransferFault fault);
    std::optional<Duration> pair(const ExplainedTransfer& transfer);
    void count(const ExplainedTransfer& transfer);

    Handler handler_;
    std::map<Key, Session> sessions_;
    std::map<Call, Duration> calls_;  ///< waiting for their response
    Duration latest_{};
    TransferTally tally_;
};

}  // namespace tribus
