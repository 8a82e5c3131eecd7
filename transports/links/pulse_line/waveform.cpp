#include "transports/links/pulse_line/waveform.h"

#include <algorithm>
#include <chrono>

#include "core/edge_records.h"
#include "core/rounding.h"

namespace tribus {
namespace {

using edge_records::EdgeKind;
using edge_records::kRecordBytes;

constexpr std::size_t kBitsAByte = 8;
/// Usual length of the pulse between two channels (docs/protocols/ppm.md).
constexpr double kPulseMicroseconds = 300;

/// Sets the bits from `begin` up to `end`.
void set_bits(SpiWaveform& waveform, std::size_t begin, std::size_t end) {
    for (std::size_t bit = begin; bit < end; ++bit) {
        waveform.bits[bit / kBitsAByte] |= static_cast<std::uint8_t>(0x80U >> bit % kBitsAByte);
    }
}

}  // namespace

bool draw_pulses(std::span<const std::uint8_t> records, double calibration, SpiWaveform& waveform) {
    constexpr double kMostBits = kMostWaveformBytes * kBitsAByte;
    const auto bits_of = [calibration](double microseconds) {
        return static_cast<std::size_t>(nearest_whole(microseconds * calibration));
    };
    waveform.bits.fill(0);
    waveform.bytes = 0;
    double at = 0;
    bool any_edge = false;
    for (std::size_t record = 0; record + kRecordBytes <= records.size(); record += kRecordBytes) {
        const auto read = edge_records::record_of(records.subspan(record, kRecordBytes));
        if (!read) {
            return false;
        }
        at += any_edge ? static_cast<double>(read->eighths) / edge_records::kEighthsPerMicrosecond
                       : 0;
        if ((at + kPulseMicroseconds) * calibration > kMostBits) {
            return false;
        }
        if (read->kind != EdgeKind::quiet) {
            set_bits(waveform, bits_of(at), bits_of(at + kPulseMicroseconds));
            any_edge = true;
        }
    }
    waveform.bytes = (bits_of(at) + kBitsAByte - 1) / kBitsAByte;
    return any_edge;
}

SpiSignal pulse_signal(double calibration) {
    return {.byte_time = std::chrono::microseconds(kBitsAByte),
            .draw = [calibration](std::span<const std::uint8_t> frame, SpiWaveform& waveform) {
                return draw_pulses(frame, calibration, waveform);
            }};
}

}  // namespace tribus
