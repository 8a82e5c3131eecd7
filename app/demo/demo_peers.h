#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// Reactions of the servos to one radio loss.
struct DropRecord {
    std::optional<Duration> frame_lost_after;  ///< since the receiver's last frame
    std::optional<Duration> failsafe_after;    ///< since the receiver's last frame
    std::optional<Duration> control_after;     ///< since the receiver's first frame after the loss
};

/// Everything that the peers know at one moment.
struct PeerReport {
    ChannelFrame sent;      ///< by the receiver
    ChannelFrame received;  ///< by the servos
    bool link_up = true;
    std::uint64_t frames_sent = 0;
    std::uint64_t frames_received = 0;
    std::uint64_t frames_fresh =
        0;  ///< of the received ones: those that carried a new receiver frame
    std::vector<Duration> latencies;  ///< of these, from the receiver's write to the servos' read
    std::vector<DropRecord> drops;
};

/// Stick positions of the simulated transmitter at a time: all 18 channels move.
ChannelFrame demo_sticks(Duration since_start);

/// A simulated 18-channel i.Bus receiver and SBUS servos, at the far ends of two ptys. Runs its own
/// thread; `report` is thread-safe.
class DemoPeers {
  public:
    DemoPeers(UniqueFd receiver, UniqueFd servos);
    DemoPeers(const DemoPeers&) = delete;
    DemoPeers& operator=(const DemoPeers&) = delete;
    ~DemoPeers() { stop(); }

    /// Everything so far. Thread-safe.
    PeerReport report();
    /// The receiver sends no more frames; the servos go on reading.
    void stop_receiver();
    /// Ends the thread and waits for it.
    void stop();

  private:
    struct Sent {
        ChannelFrame frame;
        Instant at;
        std::uint64_t number = 0;
    };
    static constexpr std::size_t kRemembered = 64;

    void main();
    void send_due(Instant now);
    void read_servos(Instant now);
    void note(const ChannelFrame& frame, Instant now);
    void note_drop(const ChannelFrame& frame, Instant now);

    UniqueFd receiver_;
    UniqueFd servos_;
    IbusEncoder encoder_{18};
    SbusDecoder decoder_;
    Instant start_;
    Instant next_send_;
    Instant latest_sent_at_{};
    Instant back_at_{};
    std::array<Sent, kRemembered> remembered_{};
    std::uint64_t latest_fresh_ = 0;

    std::mutex mutex_;
    PeerReport report_;
    bool receiver_stopped_ = false;
    bool stopping_ = false;
    std::thread thread_;
};

}  // namespace tribus
