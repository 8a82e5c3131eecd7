#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/time.h"
#include "transports/codecs/codec.h"

/// The frames of the i.Bus sensor bus (docs/protocols/ibus.md, "Sensor bus: wire" and "Sensor bus:
/// frames"): 115200 8N1, one wire for both directions, the receiver asks, sensors answer. Pure.
namespace tribus {

/// Addresses are 1 to 15; 0 is the receiver's own voltage and never on the wire.
inline constexpr std::size_t kMostSensors = 15;
/// The longest value that is known, of modified receivers: GPS_FULL.
inline constexpr std::size_t kMostSensorData = 14;
/// Length, command and address, data, checksum.
inline constexpr std::size_t kLongestSensorFrame = kMostSensorData + 4;
inline constexpr std::size_t kSensorRequestBytes = 4;

/// The high nibble of a frame's second byte.
enum class SensorCommand : std::uint8_t {
    discover = 0x8,
    type = 0x9,
    value = 0xA,
    power_up = 0xF,  ///< `04 F0 0B FF`, meaning unknown, never answered
};

struct SensorFrame {
    SensorCommand command = SensorCommand::discover;
    std::uint8_t address = 0;
    std::uint8_t data_size = 0;
    std::array<std::uint8_t, kMostSensorData> data{};
    /// Position of its first byte, counted from the first byte that the parser was ever given.
    std::uint64_t first_byte = 0;

    /// Without data: a request, or the reply to a discover request, which is the same bytes.
    bool is_request() const { return data_size == 0; }
    std::span<const std::uint8_t> payload() const { return {data.data(), data_size}; }
};

/// Writes a frame to the front of `wire` and returns its length; at most kMostSensorData bytes of
/// data. Reentrant.
std::size_t encode_sensor_frame(SensorCommand command, std::uint8_t address,
                                std::span<const std::uint8_t> data,
                                std::span<std::uint8_t, kLongestSensorFrame> wire);

/// Between two bytes of a frame, as they are read; the shortest silence between a servo frame and a
/// request on one wire is 0.8 ms, but reads come late and in lumps.
inline constexpr Duration kLongestSensorPause = std::chrono::milliseconds(3);

/// Bytes of a sensor bus in, frames out, each with the byte that completes it. Servo frames, of a
/// wire that carries both, are passed over as wholes. What is neither is skipped byte by byte; a
/// frame that does not go on for kLongestSensorPause is given up, so that one lost byte does not
/// cost the next request. Thread-bound.
///
/// What begins where a frame ended, or after a pause, is believed to be the frame that it looks
/// like, and so is a servo frame anywhere: nothing inside of it is a frame, even if its checksum is
/// wrong. What begins behind noise is not: there a request is found at once, even in a value that
/// holds a whole one and whose own beginning was lost. A request is found with its last byte or
/// not at all: later, its answer would come too late. Address 0 is refused, but for power-up.
class SensorFrameParser {
  public:
    /// Takes bytes off the front of `bytes` until a frame is complete; call again with the rest.
    /// Nothing when all bytes are taken and no further frame is complete.
    std::optional<SensorFrame> next(std::span<const std::uint8_t>& bytes, Instant received);
    /// A byte stood here in the stream that came with a framing error: what it is part of is no
    /// frame. Call `next` until it returns nothing before this.
    void damaged_byte(Instant received);

    /// What was refused, by cause; only ever incremented.
    std::span<const NamedCount> rejected() const { return rejected_; }
    /// Bytes that belonged to no frame.
    std::uint64_t skipped_bytes() const { return skipped_bytes_; }
    /// Servo frames that passed.
    std::uint64_t servo_frames() const { return servo_frames_; }

  private:
    enum RejectCause : std::size_t { kChecksum, kDamaged, kUnfinished, kUnknownCommand };
    static constexpr std::size_t kServoFrameBytes = 32;

    void give_up_after_pause(Instant received);
    std::optional<SensorFrame> judge();
    std::size_t wanted() const;
    bool ends_with_request() const;
    SensorFrame take_frame(std::size_t length);
    void skip(std::size_t count);
    void drop(std::size_t count);

    /// What is not judged yet; it may be a frame from its first byte on.
    std::array<std::uint8_t, kServoFrameBytes> kept_{};
    std::size_t size_ = 0;
    std::uint64_t position_ = 0;  ///< of the first byte kept
    /// Up to here stood a frame whose checksum was wrong: what it holds is no frame.
    std::uint64_t damaged_end_ = 0;
    bool in_step_ = true;  ///< what is kept begins where a frame may be expected to
    Instant last_{};       ///< when the byte before was received
    std::array<NamedCount, 4> rejected_{
        {{"checksum"}, {"damaged"}, {"unfinished"}, {"unknown command"}}};
    std::uint64_t skipped_bytes_ = 0;
    std::uint64_t servo_frames_ = 0;
};

}  // namespace tribus
