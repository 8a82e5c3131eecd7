#pragma once

#include <linux/can.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/links/can_interface.h"
#include "transports/links/can_link.h"
#include "transports/links/can_transmitter.h"
#include "transports/links/clock_step.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// What the users of one interface need of it.
struct CanSocketSettings {
    std::vector<CanIdMatch> wanted;  ///< ids that inputs read
    /// Ids that outputs send: confirmations come by them, and other senders of them are seen.
    std::vector<CanIdMatch> sent;
    bool fd = false;  ///< an input or output uses FD frames

    bool operator==(const CanSocketSettings&) const = default;
};

/// A SocketCAN interface. Thread-bound. No heap after `open`.
///
/// A frame counts as gone when the controller has sent it: the kernel then returns it to its
/// sender. Drivers without that (vcan, vxcan, slcan) return it at once; there it counts as gone
/// when the kernel's queue has nothing of this socket any more (docs/protocols/can.md, "SocketCAN:
/// sockets").
class CanSocket final : public CanLink {
  public:
    /// Opens the interface, also if it is down. The error begins with the interface and says what
    /// to do. May block: not for the data path.
    static tl::expected<std::unique_ptr<CanSocket>, std::string> open(
        const std::string& interface, const CanSocketSettings& settings);

    /// No network interface has that name, which is a possible one: it may be plugged in later.
    static bool is_missing(const std::string& interface);

    CanSocket(const CanSocket&) = delete;
    CanSocket& operator=(const CanSocket&) = delete;
    ~CanSocket() override;

    ReadStatus read(CanReception& reception, Instant now, Duration wall_time) override;
    /// Frames of the snapshot have ids of CanSocketSettings::sent and are no remote frames.
    WriteStatus write(std::size_t lane, std::span<const CanFrame> snapshot, Instant now) override;
    Instant poll(Instant now) override;
    CanLinkStatus status() const override { return {transmitter_.state(), counts_}; }
    int descriptor() const override { return fd_.get(); }

    /// As it was when it was opened.
    const CanInterface& interface() const { return interface_; }

    /// How often an interface that does not send is looked at.
    static constexpr Duration kRecheckPeriod = std::chrono::milliseconds(20);
    /// After an interface has come up, the kernel may show its carrier so much later.
    static constexpr Duration kCarrierLag = std::chrono::seconds(2);
    /// Where nothing tells that a frame has gone: three frames of 1 Mbit/s.
    static constexpr Duration kQueueCheckPeriod = std::chrono::microseconds(500);
    /// Room for some hundred frames, each of which takes about 800 bytes of the kernel's memory:
    /// 50 ms of a full bus.
    static constexpr int kReceiveBufferBytes = 256 * 1024;

  private:
    struct Buffers;
    /// Bytes that the kernel holds for sending, and frames that it has dropped since `open`.
    struct KernelQueues {
        std::uint32_t sending = 0;
        std::uint32_t drops = 0;
    };

    CanSocket(UniqueFd fd, CanInterface interface);

    std::optional<ReceivedCanFrame> digest(std::size_t index, Instant now, Duration wall_time);
    void digest_error(const canfd_frame& wire, Instant now);
    ReadStatus read_failed(int error, Instant now, Duration wall_time);
    void note_drops(std::uint32_t drops);
    void pump(Instant now);
    void send_failed(int error, Instant now);
    void recheck(Instant now);
    void check_line(Instant now);
    void went_down();
    bool flight_landed(Instant now);
    KernelQueues kernel_queues() const;
    bool works() const;

    UniqueFd fd_;
    CanInterface interface_;
    CanCounts counts_;
    CanTransmitter transmitter_{counts_};
    std::unique_ptr<Buffers> buffers_;
    std::optional<Instant> emptied_;  ///< when a read last left nothing behind
    ClockStep clock_step_;            ///< since then
    bool stamps_tell_ = true;         ///< of the read that goes on
    Instant checked_{};
    std::uint32_t drops_ = 0;
    std::uint32_t drops_when_handed_ = 0;
    std::optional<Instant> up_since_;
    bool no_carrier_ = false;  ///< in bus-off: seen without carrier, so it must come back
    bool lost_ = false;
};

}  // namespace tribus
