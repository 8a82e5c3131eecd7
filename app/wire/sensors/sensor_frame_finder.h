#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "app/wire/frames/frame_finder.h"
#include "app/wire/sensors/sensor_conversation.h"
#include "core/time.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/recordings/recording_source.h"

namespace tribus {

/// Counters of a sensor bus parser.
struct SensorTally {
    Tally frames;
    std::uint64_t servo_frames = 0;
};

/// Runs the sensor bus parser over bursts and reports when each frame starts and ends. Within a
/// burst, bytes have the distance that genuine receivers and sensors use, one bit of silence
/// between two (docs/protocols/ibus.md, "Line"): a request ends 43 bits after its start.
class SensorFrameFinder final : public RecordingTaker {
  public:
    using Handler = std::function<void(const ReceivedSensorFrame&)>;
    explicit SensorFrameFinder(Handler handler);

    void feed_burst(std::size_t index, const Burst& burst) override;
    SensorTally tally() const;

  private:
    /// More than the parser ever keeps.
    static constexpr std::size_t kRememberedBytes = 64;

    void feed_byte(std::uint8_t byte, bool damaged, std::optional<Duration> start);
    std::optional<Duration> start_of(std::uint64_t position) const {
        return starts_[position % kRememberedBytes];
    }

    Handler handler_;
    SensorFrameParser parser_;
    std::array<std::optional<Duration>, kRememberedBytes> starts_{};
    std::uint64_t bytes_ = 0;
    std::uint64_t frames_ = 0;
};

/// True if at least half of the bytes belong to frames of the sensor bus.
bool is_sensor_bus(RecordingSource& recording);

}  // namespace tribus
