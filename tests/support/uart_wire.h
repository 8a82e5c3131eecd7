#pragma once

#include <algorithm>
#include <bit>
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
    void send(Duration start, std::span<const std::uint8_t> bytes, unsigned pause_bits = 0) {
        const LineSettings& line = sender_.line;
        const Duration begin = std::max(start, end_);
        std::uint64_t bit = 0;
        for (const std::uint8_t byte : bytes) {
            const auto put = [&](bool mark) { level(begin + line.bits_time(bit++), mark); };
            put(false);
            for (unsigned data = 0; data < 8; ++data) {
                put((byte >> data & 1U) != 0);
            }
            if (line.parity == Parity::even) {
                put((std::popcount(byte) % 2 != 0) != sender_.odd_parity);
            }
            put(true);
            bit += line.stop_bits - 1U + pause_bits;
        }
        end_ = begin + line.bits_time(bit);
    }
    Duration end() const { return end_; }
    /// Level that a UART sees: a mark is high. Fastest if the times of successive calls rise.
    bool high_at(Duration time) const {
        if (at_ > 0 && changes_[at_ - 1].at > time) {
            at_ = 0;
        }
        while (at_ < changes_.size() && changes_[at_].at <= time) {
            ++at_;
        }
        return at_ == 0 ? !sender_.inverted : changes_[at_ - 1].high;
    }
    /// Time of the next edge from `time` on, or nothing if there is none.
    std::optional<Duration> next_fall(Duration time) const { return next(time, false); }
    std::optional<Duration> next_rise(Duration time) const { return next(time, true); }

  private:
    struct Change {
        Duration at{};
        bool high = true;
    };
    void level(Duration at, bool mark) {
        const bool high = mark != sender_.inverted;
        if (high != high_) {
            changes_.push_back({at, high});
            high_ = high;
        }
    }
    std::optional<Duration> next(Duration time, bool high) const {
        high_at(time - Duration(1));
        std::size_t at = at_;
        while (at < changes_.size() && changes_[at].high != high) {
            ++at;
        }
        return at == changes_.size() ? std::nullopt : std::optional(changes_[at].at);
    }

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

    std::vector<Burst> listen(const Wire& wire) {
        heard_.clear();
        auto start = wire.high_at(Duration::zero()) ? wire.next_fall(Duration::zero())
                                                    : after_break(wire, Duration::zero());
        while (start) {
            start = take(wire, *start);
        }
        return heard_;
    }

  private:
    bool sample(const Wire& wire, Duration start, std::uint64_t bit) const {
        return wire.high_at(start + line_.bits_time(2 * bit + 1) / 2);
    }
    static std::optional<Duration> after_break(const Wire& wire, Duration from) {
        const auto rise = wire.next_rise(from);
        return rise ? wire.next_fall(*rise) : std::nullopt;
    }
    /// Reads one byte. Returns where the next one starts.
    std::optional<Duration> take(const Wire& wire, Duration start) {
        unsigned value = 0;
        for (unsigned data = 0; data < 8; ++data) {
            value |= (sample(wire, start, 1 + data) ? 1U : 0U) << data;
        }
        std::uint64_t bit = 9;
        bool damaged = false;
        bool silent = value == 0;
        if (line_.parity == Parity::even) {
            const bool parity = sample(wire, start, bit++);
            damaged = parity != (std::popcount(value) % 2 != 0);
            silent = silent && !parity;
        }
        const bool stop = sample(wire, start, bit);
        const Duration stop_at = start + line_.bits_time(2 * bit + 1) / 2;
        heard_.push_back({.start = stop_at,
                          .bytes = {static_cast<std::uint8_t>(value)},
                          .damaged = {damaged || !stop}});
        if (stop) {
            return wire.next_fall(stop_at);
        }
        if (silent || kind_ == UartKind::waits_for_idle) {
            return after_break(wire, stop_at);
        }
        return start + line_.bits_time(bit);
    }

    LineSettings line_;
    UartKind kind_;
    std::vector<Burst> heard_;
};

/// The reads of a program whose adapter delivers its bytes once each `step`.
inline std::vector<Burst> in_lumps(std::span<const Burst> bytes, Duration step) {
    std::vector<Burst> lumps;
    for (const Burst& byte : bytes) {
        const Duration at = (*byte.start / step + 1) * step;
        if (lumps.empty() || *lumps.back().start != at) {
            lumps.push_back({.start = at, .bytes = {}, .damaged = {}});
        }
        lumps.back().bytes.push_back(byte.bytes[0]);
        lumps.back().damaged.push_back(byte.damaged[0]);
    }
    return lumps;
}

}  // namespace tribus::test
