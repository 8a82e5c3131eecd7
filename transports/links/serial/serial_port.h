#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "core/line_settings.h"
#include "transports/links/link.h"
#include "transports/links/serial/parity_marks.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// A serial device of Linux (UART, USB adapter, pty) as a link of raw bytes. Thread-bound.
///
/// A byte with a parity or framing error is received as damaged, a break as a damaged zero.
class SerialPort : public ByteLink {
  public:
    /// Opens `device`, a path, for this program alone (follows links as in /dev/serial/by-id), sets
    /// the line and checks that the port keeps the settings. Discards earlier bytes. The error
    /// begins with the device and says what to do. Blocks as long as the driver needs: not for the
    /// data path.
    static tl::expected<std::unique_ptr<SerialPort>, std::string> open(
        const std::string& device, const LineSettings& settings);

    /// Whether nothing has that name: it may be plugged in later.
    static bool is_missing(const std::string& device);

    SerialPort(const SerialPort&) = delete;
    SerialPort& operator=(const SerialPort&) = delete;
    /// Waits at most `kMostDrainMilliseconds` for the frame that is being sent and discards the
    /// rest, so that a stuck adapter cannot delay the caller.
    ~SerialPort() override;

    ReadStatus read(Reception& reception) override;

    bool has_unread() const override;
    void discard_unread() override;

    /// Writes only if the kernel's output queue is empty: a frame that waits there is stale when it
    /// is sent. Discards a frame that the kernel does not accept completely. A pty has no such
    /// queue: it accepts about 20 kB of unread bytes and is busy then.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    WriteStatus ask() override;
    WriteStatus write_asked(std::span<const std::uint8_t> frame, FrameLife life) override;

    int descriptor() const override { return fd_.get(); }
    bool wakes_at_each_arrival() const override { return true; }

    /// Several times the longest frame on the line (SBUS 3 ms, i.Bus 3.1 ms).
    static constexpr int kMostDrainMilliseconds = 20;

  private:
    explicit SerialPort(UniqueFd fd) : fd_(std::move(fd)) {}

    UniqueFd fd_;
    ParityMarks marks_;
    bool lost_ = false;
};

}  // namespace tribus
