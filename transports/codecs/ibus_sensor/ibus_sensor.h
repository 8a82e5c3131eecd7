#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/protocol.h"

/// Frames of the i.Bus sensor bus (docs/protocols/ibus.md, "Sensor bus: wire" and "Sensor bus:
/// frames"): 115200 8N1, one wire for both directions. The receiver asks, sensors answer. Pure.
namespace tribus {

/// Name of the protocol on the bus, where a protocol is chosen or reported.
inline constexpr std::string_view kSensorBusName = "ibus-sensor";

/// The protocol of the bus. It has no channels, so no input or output has it.
extern const Protocol kSensorBusProtocol;

/// Number of addresses, 1 to 15. Address 0 is the receiver's own voltage and never on the wire.
inline constexpr std::size_t kMostSensors = 15;
/// Longest known value in bytes: GPS_FULL of modified receivers.
inline constexpr std::size_t kMostSensorData = 14;
/// Length, command and address, data, checksum.
inline constexpr std::size_t kLongestSensorFrame = kMostSensorData + 4;
inline constexpr std::size_t kSensorRequestBytes = 4;

/// Command of a frame: the high nibble of its second byte.
enum class SensorCommand : std::uint8_t {
    discover = 0x8,
    type = 0x9,
    value = 0xA,
    power_up = 0xF,  ///< `04 F0 0B FF`, meaning unknown, never answered
};

/// One frame of the sensor bus, request or answer.
struct SensorFrame {
    SensorCommand command = SensorCommand::discover;
    std::uint8_t address = 0;
    std::uint8_t data_size = 0;
    std::array<std::uint8_t, kMostSensorData> data{};
    /// Position of its first byte, counted from the first byte that the parser was given.
    std::uint64_t first_byte = 0;

    /// Whether it has no data: a request, or the answer to a discover request, which is the same
    /// bytes.
    bool is_request() const { return data_size == 0; }
    std::span<const std::uint8_t> payload() const { return {data.data(), data_size}; }
};

/// Writes a frame to the front of `wire` and returns its length. Uses at most kMostSensorData bytes
/// of `data`. Reentrant.
std::size_t encode_sensor_frame(SensorCommand command, std::uint8_t address,
                                std::span<const std::uint8_t> data,
                                std::span<std::uint8_t, kLongestSensorFrame> wire);

/// Longest pause between two bytes of a frame, as they are read. The shortest silence between a
/// servo frame and a request on one wire is 0.8 ms, but reads come late and in lumps.
inline constexpr Duration kLongestSensorPause = std::chrono::milliseconds(3);

/// Bytes of a sensor bus in, frames out, each with the byte that completes it. Servo frames on the
/// same wire are passed over as a whole; other bytes are skipped one by one. A frame is given up
/// after a pause of kLongestSensorPause, so that one lost byte does not cost the next request.
/// Thread-bound.
///
/// A frame that begins where another ended or after a pause is in step: until its length has
/// passed, nothing inside it is taken for a frame, even if its checksum is wrong. The same holds
/// for a servo frame anywhere. A frame that begins after noise is not in step: a request is then
/// found at once, even inside a value that holds a whole one and whose beginning was lost. A
/// request is found with its last byte or not at all, because a later answer would come too late.
/// Address 0 is refused, except in power-up.
class SensorFrameParser {
  public:
    /// Removes bytes from the front of `bytes` until a frame is complete; call again with the rest.
    /// Returns nothing when all bytes are taken and no further frame is complete.
    std::optional<SensorFrame> next(std::span<const std::uint8_t>& bytes, Instant received);
    /// A byte with a framing error stood here in the stream. It spoils the frame around it. Before
    /// this, call `next` until it returns nothing.
    void damaged_byte(Instant received);

    /// Refused frames by cause. The counts only ever increase.
    std::span<const NamedCount> rejected() const { return rejected_; }
    /// Bytes that belonged to no frame.
    std::uint64_t skipped_bytes() const { return skipped_bytes_; }
    /// Servo frames that were passed over.
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

    /// Undecided bytes. A frame may begin with the first one.
    std::array<std::uint8_t, kServoFrameBytes> kept_{};
    std::size_t size_ = 0;
    std::uint64_t position_ = 0;  ///< of the first byte in `kept_`
    /// End of the latest frame with a wrong checksum: nothing before it is taken for a frame.
    std::uint64_t damaged_end_ = 0;
    bool in_step_ = true;  ///< a frame is expected to begin with the first byte in `kept_`
    Instant last_{};       ///< when the byte before was received
    std::array<NamedCount, 4> rejected_{
        {{"checksum"}, {"damaged"}, {"unfinished"}, {"unknown command"}}};
    std::uint64_t skipped_bytes_ = 0;
    std::uint64_t servo_frames_ = 0;
};

}  // namespace tribus
