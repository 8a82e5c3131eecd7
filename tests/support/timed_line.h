#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/time.h"
#include "pipelines/engine/input.h"
#include "tests/support/streams.h"
#include "transports/codecs/codec.h"

/// Bytes on a wire with their times, and ports that deliver them as real ports do.
namespace tribus::test {

/// 100000 baud 8E2; docs/protocols/sbus.md, "Line".
inline constexpr Duration kSbusByteTime = std::chrono::microseconds(120);

struct WireByte {
    std::uint8_t value = 0;
    Duration end{};  ///< time of the end of its last bit
};
using TimedLine = std::vector<WireByte>;

/// Adds bytes without gaps from `start` on. Returns when the last one ends.
inline Duration put(TimedLine& line, std::span<const std::uint8_t> bytes, Duration start,
                    Duration byte_time = kSbusByteTime) {
    for (const std::uint8_t byte : bytes) {
        start += byte_time;
        line.push_back({byte, start});
    }
    return start;
}

struct TimedRead {
    Bytes bytes;
    Duration at{};
};
using Port = std::function<std::vector<TimedRead>(const TimedLine&)>;

/// A port where each byte wakes the reader, which is up to 0.1 ms late.
inline std::vector<TimedRead> byte_by_byte(const TimedLine& line) {
    std::vector<TimedRead> reads;
    Random random(7);
    for (const WireByte& byte : line) {
        reads.push_back({{byte.value}, byte.end + std::chrono::microseconds(random.below(100))});
    }
    return reads;
}

/// A UART with a FIFO: the reader wakes when eight bytes wait, or when fewer have waited for the
/// time of four bytes.
inline std::vector<TimedRead> out_of_a_fifo(const TimedLine& line) {
    constexpr std::size_t kTrigger = 8;
    constexpr Duration kTimeout = 4 * kSbusByteTime;
    std::vector<TimedRead> reads;
    TimedRead waiting;
    for (std::size_t i = 0; i < line.size(); ++i) {
        waiting.bytes.push_back(line[i].value);
        const bool pause = i + 1 == line.size() || line[i + 1].end - line[i].end > kTimeout;
        if (pause || waiting.bytes.size() == kTrigger) {
            waiting.at =
                line[i].end + (waiting.bytes.size() == kTrigger ? Duration::zero() : kTimeout);
            reads.push_back(std::exchange(waiting, {}));
        }
    }
    return reads;
}

/// A pty whose other end writes bytes that follow each other in one call.
inline std::vector<TimedRead> in_bursts(const TimedLine& line) {
    std::vector<TimedRead> reads;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (i == 0 || line[i].end - line[i - 1].end > 2 * kSbusByteTime) {
            reads.emplace_back();
        }
        reads.back().bytes.push_back(line[i].value);
        reads.back().at = line[i].end;
    }
    return reads;
}

/// An adapter that delivers all bytes that have come once each `step` (FTDI's latency timer;
/// docs/protocols/sbus.md, "Serial port: latency").
inline Port in_lumps_each(Duration step) {
    return [step](const TimedLine& line) {
        std::vector<TimedRead> reads;
        for (const WireByte& byte : line) {
            const Duration at = (byte.end / step + 1) * step;
            if (reads.empty() || reads.back().at != at) {
                reads.push_back({{}, at});
            }
            reads.back().bytes.push_back(byte.value);
        }
        return reads;
    };
}

struct NamedPort {
    std::string_view name;
    Port port;
};
inline std::vector<NamedPort> prompt_ports() {
    return {{"byte by byte", byte_by_byte}, {"FIFO", out_of_a_fifo}, {"bursts", in_bursts}};
}

/// Returns the frames that an input makes of what a port delivers, the last one of each read.
inline std::vector<ChannelFrame> frames_of(std::unique_ptr<ByteDecoder> decoder,
                                           const TimedLine& line, const Port& port) {
    Input input({.name = "in", .decoder = std::move(decoder), .byte_time = kSbusByteTime}, 0);
    std::vector<ChannelFrame> frames;
    for (const TimedRead& read : port(line)) {
        if (input.receive(read.bytes, Instant(read.at))) {
            frames.push_back(input.latest());
        }
    }
    return frames;
}

}  // namespace tribus::test
