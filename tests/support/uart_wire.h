#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/line_settings.h"
#include "core/time.h"
#include "transports/recordings/recording.h"

/// The level of a serial wire, bit by bit, and the bytes that a UART with given settings reads from
/// it.
namespace tribus::test {

/// Settings of a sender. `odd_parity` counts only if the line has parity.
struct SenderLine {
    LineSettings line;
    bool inverted = false;
    bool odd_parity = false;
};

/// Changes of the wire's level in the order of time. The wire starts idle.
class Wire {
  public:
    explicit Wire(const SenderLine& sender) : sender_(sender), high_(!sender.inverted) {}

    /// Sends bytes from `start` on, or after the bytes already sent, with `pause_bits` between two
    /// bytes.
    void send(Duration start, std::span<const std::uint8_t> bytes, unsigned pause_bits = 0);
    Duration end() const { return end_; }
    /// Level that a UART sees: a mark is high. Fastest if the times of successive calls rise.
    bool high_at(Duration time) const;
    /// Time of the next edge from `time` on, or nothing if there is none.
    std::optional<Duration> next_fall(Duration time) const { return next(time, false); }
    std::optional<Duration> next_rise(Duration time) const { return next(time, true); }

  private:
    struct Change {
        Duration at{};
        bool high = true;
    };
    void level(Duration at, bool mark);
    std::optional<Duration> next(Duration time, bool high) const;

    SenderLine sender_;
    bool high_;
    Duration end_{};
    std::vector<Change> changes_;
    mutable std::size_t at_ = 0;  ///< index of the change after the time of the last query
};

enum class UartKind : std::uint8_t {
    /// After a framing error it waits until the line is high, as a PL011 does.
    waits_for_idle,
    /// After a framing error it takes the bit in place of the stop bit for the next start bit, as a
    /// 16550 does.
    takes_error_for_start,
};

/// The bytes that a UART reads. Each byte is a burst at the time of its stop bit.
class UartEar {
  public:
    UartEar(const LineSettings& line, UartKind kind) : line_(line), kind_(kind) {}

    std::vector<Burst> listen(const Wire& wire);

  private:
    /// Reads one byte. Returns where the next one starts.
    std::optional<Duration> take(const Wire& wire, Duration start);

    LineSettings line_;
    UartKind kind_;
    std::vector<Burst> heard_;
};

/// The reads of a program whose adapter delivers its bytes once each `step`.
std::vector<Burst> in_lumps(std::span<const Burst> bytes, Duration step);

}  // namespace tribus::test
