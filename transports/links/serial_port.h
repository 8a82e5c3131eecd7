#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "core/line_settings.h"
#include "transports/links/link.h"
#include "transports/links/parity_marks.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// A serial device of Linux (UART, USB adapter, pty) as a link of raw bytes. Thread-bound.
///
/// A byte with a parity or framing error arrives as a damaged one, a break as a damaged zero.
class SerialPort : public ByteLink {
  public:
    /// Opens `device`, a path (links as under /dev/serial/by-id are followed), for this program
    /// alone, sets the line and checks that the port really keeps it. What came in before is
    /// thrown away. The error begins with the device and says what to do. Blocks for as long as
    /// the driver takes: not for the data path.
    static tl::expected<std::unique_ptr<SerialPort>, std::string> open(
        const std::string& device, const LineSettings& settings);

    /// Nothing has that name: it may be plugged in later.
    static bool is_missing(const std::string& device);

    SerialPort(const SerialPort&) = delete;
    SerialPort& operator=(const SerialPort&) = delete;
    /// Waits for the frame that is on its way, at most `kMostDrainMilliseconds`, and throws away
    /// what is left, so that a stuck adapter cannot hold up the caller.
    ~SerialPort() override;

    ReadStatus read(Reception& reception) override;

    void discard_unread() override;

    /// Writes only if the kernel's output queue is empty: a frame that waits there is stale when
    /// it leaves. What the kernel does not take whole is thrown away. A pty has no such queue: it
    /// takes bytes until nobody has read about 20 kB, and is busy then.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    WriteStatus ask() override;
    WriteStatus write_asked(std::span<const std::uint8_t> frame) override;

    int descriptor() const override { return fd_.get(); }

    /// Several times the longest frame on the wire (SBUS 3 ms, i.Bus 3.1 ms).
    static constexpr int kMostDrainMilliseconds = 20;

  private:
    explicit SerialPort(UniqueFd fd) : fd_(std::move(fd)) {}

    UniqueFd fd_;
    ParityMarks marks_;
    bool lost_ = false;
};

}  // namespace tribus
