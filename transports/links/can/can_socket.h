#pragma once

#include <linux/can.h>

#include <array>
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
#include "transports/links/can/can_interface.h"
#include "transports/links/can/can_link.h"
#include "transports/links/can/can_transmitter.h"
#include "transports/links/can/clock_step.h"
#include "transports/links/medium.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// A SocketCAN interface. Thread-bound. No heap after `open`. A snapshot leaves in one system call,
/// and what waits is read in one.
///
/// A frame is sent when the controller has sent it: the kernel then returns it to the sender.
/// Drivers without this (vcan, vxcan, slcan) return it at once; for them, a frame is sent when the
/// kernel's queue has none of this socket left (docs/protocols/can.md, "SocketCAN: sockets").
class CanSocket final : public CanLink {
  public:
    /// Opens the interface, even if it is down. The error begins with the interface and says what
    /// to do. May block: not for the data path.
    static tl::expected<std::unique_ptr<CanSocket>, std::string> open(const std::string& interface,
                                                                      const LinkUse& settings);

    /// Whether no network interface has that name although it is valid: it may be plugged in later.
    static bool is_missing(const std::string& interface);

    /// Uses sockets that are open: a raw one that is bound to the interface, and one of
    /// `watch_interfaces` from before the interface was read.
    CanSocket(UniqueFd fd, UniqueFd changes, CanInterface interface);
    CanSocket(const CanSocket&) = delete;
    CanSocket& operator=(const CanSocket&) = delete;
    ~CanSocket() override;

    ReadStatus read(CanReception& reception, Instant now, Duration wall_time) override;
    /// All frames need ids of LinkUse::sent and must not be remote frames.
    WriteStatus write(std::size_t lane, std::span<const CanFrame> snapshot, Instant now) override;
    Instant poll(Instant now) override;
    CanBusState state() const override { return transmitter_.state(); }
    CanLinkStatus status() const override { return {transmitter_.state(), counts_}; }
    int descriptor() const override { return fd_.get(); }
    int second_descriptor() const override { return changes_.get(); }

    /// The interface as it was when it was opened.
    const CanInterface& interface() const { return interface_; }

    /// Period of the checks of an interface that does not send.
    static constexpr Duration kRecheckPeriod = std::chrono::milliseconds(20);
    /// Longest delay between an interface coming up and the kernel showing its carrier.
    static constexpr Duration kCarrierLag = std::chrono::seconds(2);
    /// Period of the checks whether a frame was sent, for drivers without confirmations: three
    /// frames at 1 Mbit/s.
    static constexpr Duration kQueueCheckPeriod = std::chrono::microseconds(500);
    /// Receive buffer for some hundred frames, 50 ms of a full bus. A frame takes about 800 bytes
    /// of kernel memory.
    static constexpr int kReceiveBufferBytes = 256 * 1024;

  private:
    struct Buffers;
    /// Bytes that the kernel holds for sending, and frames that it has dropped since `open`.
    struct KernelQueues {
        std::uint32_t sending = 0;
        std::uint32_t drops = 0;
    };

    std::optional<ReceivedCanFrame> process(std::size_t index, Instant now, Duration wall_time);
    void process_error(const canfd_frame& wire, Instant now);
    ReadStatus read_failed(int error, Instant now, Duration wall_time);
    void emptied(Instant now, Duration wall_time);
    void note_drops(std::uint32_t drops);
    void pump(Instant now);
    void send(std::span<const CanFrame> frames, Instant now);
    bool read_changes(Instant now);
    void send_failed(int error, Instant now);
    void recheck(Instant now);
    void check_line(Instant now);
    void judge_line(Instant now);
    void went_down();
    bool flight_is_over(Instant now);
    KernelQueues kernel_queues() const;
    bool works() const;

    UniqueFd fd_;
    UniqueFd changes_;
    CanInterface interface_;
    bool is_up_;       ///< as the kernel told last
    bool is_running_;  ///< likewise
    /// A message on a change of the interface; its beginning is enough.
    std::array<std::byte, 2048> change_{};
    CanCounts counts_;
    CanTransmitter transmitter_;
    std::unique_ptr<Buffers> buffers_;
    std::optional<Instant> emptied_;  ///< when a read last emptied the socket
    ClockStep clock_step_;            ///< since then
    bool stamps_usable_ = true;       ///< whether the stamps of the current read are usable
    Instant checked_{};
    std::uint32_t drops_ = 0;  ///< as far as the reads told
    std::uint32_t drops_when_handed_ = 0;
    bool drops_unread_ = false;  ///< a read was full, so the kernel may have dropped frames
    std::optional<Instant> up_since_;
    bool awaits_carrier_ = false;  ///< it just came up, and the kernel does not show its carrier
    bool no_carrier_ = false;      ///< in bus-off: the carrier was gone, so it must return
    bool lost_ = false;
};

}  // namespace tribus
