#include "app/wire/sensors/sensor_frame_finder.h"

#include <utility>

#include "core/line_settings.h"

namespace tribus {
namespace {

/// The line of the sensor bus: 115200 8N1.
constexpr LineSettings kLine{};
constexpr unsigned kSpacingBits = kLine.bits_per_byte() + 1;

}  // namespace

SensorFrameFinder::SensorFrameFinder(Handler handler) : handler_(std::move(handler)) {}

void SensorFrameFinder::feed_burst(std::size_t /*index*/, const Burst& burst) {
    for (std::size_t at = 0; at < burst.bytes.size(); ++at) {
        auto start = burst.start;
        if (start) {
            *start += kLine.bits_time(at * kSpacingBits);
        }
        const bool damaged = at < burst.damaged.size() && burst.damaged[at];
        feed_byte(burst.bytes[at], damaged, start);
    }
}

void SensorFrameFinder::feed_byte(std::uint8_t byte, bool damaged, std::optional<Duration> start) {
    const Instant received(start.value_or(Duration::zero()));
    starts_[bytes_ % kRememberedBytes] = start;
    ++bytes_;
    if (damaged) {
        parser_.damaged_byte(received);
        return;
    }
    std::span<const std::uint8_t> bytes(&byte, 1);
    while (const auto frame = parser_.next(bytes, received)) {
        ReceivedSensorFrame found{.frame = *frame, .start = start_of(frame->first_byte)};
        found.end = start_of(frame->first_byte + kSensorRequestBytes + frame->data_size - 1);
        if (found.end) {
            *found.end += kLine.bytes_time(1);
        }
        ++frames_;
        handler_(found);
    }
}

SensorTally SensorFrameFinder::tally() const {
    const auto rejected = parser_.rejected();
    return {.frames = {.bytes = bytes_,
                       .frames = frames_,
                       .rejected = {rejected.begin(), rejected.end()},
                       .skipped_bytes = parser_.skipped_bytes()},
            .servo_frames = parser_.servo_frames()};
}

bool is_sensor_bus(RecordingSource& recording) {
    std::uint64_t in_frames = 0;
    SensorFrameFinder finder([&](const ReceivedSensorFrame& received) {
        in_frames += kSensorRequestBytes + received.frame.data_size;
    });
    recording.read(finder);
    return in_frames > 0 && 2 * in_frames >= finder.tally().frames.bytes;
}

}  // namespace tribus
