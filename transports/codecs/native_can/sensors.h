#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/setting.h"
#include "core/time.h"
#include "core/value_board.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/codecs/protocol.h"

/// The readings of a sensor bus on CAN: one frame of 8 bytes for each address, with the raw value
/// that the sensor sent. The format is tribus' own.
///
///   byte 0     id of the sensor's type, which gives the meaning of the raw value
///   byte 1     bit 0: the reading is fresh; bits 4 to 7: counter, 0 to 15
///   bytes 2-3  age of the reading in ms, low byte first; 65535 is that or more
///   bytes 4-7  the raw value, low byte first, extended to 32 bits by the sign of its type
namespace tribus {

namespace sensor_can {

inline constexpr std::uint32_t kDefaultBaseId = 0x320;
inline constexpr Duration kDefaultPeriod = std::chrono::milliseconds(100);
inline constexpr std::size_t kTypeByte = 0;
inline constexpr std::size_t kStateByte = 1;
inline constexpr std::uint8_t kAvailableBit = 0x01;
inline constexpr unsigned kCounterShift = 4;
inline constexpr std::uint8_t kMostCounter = 15;
inline constexpr std::size_t kAgeByte = 2;
inline constexpr std::size_t kRawByte = 4;

}  // namespace sensor_can

extern const Protocol kSensorsProtocol;

struct SensorCanFormat {
    std::string sensor_bus{};                            ///< name of the bus
    std::uint32_t base_id = sensor_can::kDefaultBaseId;  ///< id of address 1
    bool extended = false;

    static SensorCanFormat from_settings(const SettingValues& settings);
};

/// Sends the values `BUS.N.raw` of the board, whose tags are the ids of the types, for each address
/// N that ever had one, fresh or not. Ignores the channels of the snapshot. Thread-bound.
class SensorCanEncoder final : public CanEncoder {
  public:
    explicit SensorCanEncoder(SensorCanFormat format);

    std::span<const CanIdMatch> sent() const override { return sent_; }
    void use(const ValueBoard& board) override;
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 0; }
    bool marks_frame_lost() const override { return false; }
    void continue_from(const Encoder& before) override;
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant now) override;

  private:
    CanFrame make_frame(std::size_t address, Instant now);

    SensorCanFormat format_;
    const ValueBoard* board_ = nullptr;
    std::array<CanIdMatch, kMostSensors> sent_{};  ///< one for each address from 1
    std::array<std::optional<std::size_t>, kMostSensors> indexes_{};  ///< on the board
    std::array<std::uint8_t, kMostSensors> counters_{};
};

static_assert(kMostSensors <= kMostSnapshotFrames);

}  // namespace tribus
